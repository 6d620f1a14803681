//! Settings of a bus: broker, credentials, timing.

use std::fmt;
use std::net::{IpAddr, ToSocketAddrs};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use crate::names::LONGEST;
use crate::notice::BusNotice;
use crate::tls::TlsSettings;

/// User and password with which RabbitMQ is installed.
const GUEST: &str = "guest";

/// Settings of a bus. [`parse`](Self::parse) sets all of them from an address and defaults.
#[derive(Clone)]
pub struct AmqpSettings {
    /// Host name or address of the broker.
    pub host: String,
    /// TCP port of the broker (AMQP: 5672, AMQPS: 5671).
    pub port: u16,
    /// Name of the virtual host: one for each robot or cell.
    pub vhost: String,
    /// Encryption; `None` for a plain connection.
    pub tls: Option<TlsSettings>,
    /// Credentials for the broker.
    pub credentials: Credentials,
    /// Robot name, used as the routing-key prefix: keys are `<robot>.<topic>`. Without it, topics are complete keys,
    /// as tools need them.
    pub robot: Option<String>,
    /// Name of the process, shown to operators with its connections and queues.
    pub process: String,
    /// `true` if the event queues have the same names in every run of the process. A run then discards and counts the messages
    /// that an earlier one left in them. `false`, the default, gives each bus queues of its own, which tools need.
    pub returns: bool,
    /// Name of the topic exchange.
    pub exchange: String,
    /// Name of the clock that stamps the messages, for example `wall:rover1`.
    pub clock: String,
    /// Seed of the jitter between connection attempts.
    pub seed: u64,
    /// Intervals and time limits.
    pub timing: AmqpTiming,
    /// Receives the bus's [`BusNotice`]s. Called in the bus thread; must return quickly.
    pub notices: Arc<dyn Fn(&BusNotice) + Send + Sync>,
}

/// Intervals and time limits of a bus.
#[derive(Debug, Clone, Copy)]
pub struct AmqpTiming {
    /// Time limit for a connection attempt as a whole.
    pub connect: Duration,
    /// AMQP heartbeat in seconds, at least 2. The client notices a dead peer after twice this time.
    pub heartbeat: u16,
    /// Delay before the first attempt to reconnect.
    pub first_retry: Duration,
    /// Longest delay between connection attempts.
    pub last_retry: Duration,
    /// Share of each delay that is random, from 0.0 (none) to 1.0 (all of it).
    pub jitter: f64,
    /// Interval of the liveness probes.
    pub pulse: Duration,
    /// Time without a reply after which the broker is reported as not responding.
    pub silence_timeout: Duration,
    /// Time without a reply after which the connection is closed.
    pub dead_timeout: Duration,
    /// Time that the broker keeps the event queue of a disconnected client.
    pub reply_retention: Duration,
    /// Time limit for sending pending messages when the bus closes.
    pub drain: Duration,
}

impl AmqpTiming {
    /// Longest time that an incoming message can have waited unnoticed: twice the interval of the probes, one of which is always on
    /// its way.
    pub(crate) fn unnoticed_wait(&self) -> Duration {
        2 * self.pulse
    }
}

impl Default for AmqpTiming {
    fn default() -> Self {
        Self {
            connect: Duration::from_secs(5),
            heartbeat: 4,
            first_retry: Duration::from_millis(100),
            last_retry: Duration::from_secs(2),
            jitter: 0.5,
            pulse: Duration::from_millis(250),
            silence_timeout: Duration::from_secs(1),
            dead_timeout: Duration::from_secs(5),
            reply_retention: Duration::from_secs(120),
            drain: Duration::from_secs(2),
        }
    }
}

/// A user and a password. The password is never shown.
#[derive(Clone, PartialEq, Eq)]
pub struct Credentials {
    user: String,
    password: String,
}

impl Credentials {
    /// Creates credentials from a user name and a password.
    pub fn new(user: impl Into<String>, password: impl Into<String>) -> Self {
        Self {
            user: user.into(),
            password: password.into(),
        }
    }

    /// Reads user name and password from two environment variables.
    ///
    /// # Errors
    /// [`AddressError::Variable`] with the first one that is not set, or is not Unicode.
    pub fn from_environment(user: &str, password: &str) -> Result<Self, AddressError> {
        let read = |name: &str| {
            std::env::var(name).map_err(|_| AddressError::Variable {
                name: name.to_owned(),
            })
        };
        Ok(Self::new(read(user)?, read(password)?))
    }

    /// Reads the user name from the first line of a file, and the password from the second.
    ///
    /// # Errors
    /// [`AddressError::File`] if the file cannot be read or has fewer than two lines.
    pub fn from_file(path: &Path) -> Result<Self, AddressError> {
        let unread = |reason: String| AddressError::File {
            path: path.display().to_string(),
            reason,
        };
        let text = std::fs::read_to_string(path).map_err(|error| unread(error.to_string()))?;
        let mut lines = text.lines();
        match (lines.next(), lines.next()) {
            (Some(user), Some(password)) => Ok(Self::new(user, password)),
            (None, _) | (_, None) => Err(unread(
                "expected two lines: the user and the password".to_owned(),
            )),
        }
    }

    /// Returns the user name.
    pub fn user(&self) -> &str {
        &self.user
    }

    pub(crate) fn password(&self) -> &str {
        &self.password
    }
}

impl fmt::Debug for Credentials {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:***", self.user)
    }
}

/// Error in a broker address or its credentials. Never contains the password.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum AddressError {
    /// The address does not have the form `amqp://user:password@host:port/vhost`.
    #[error("invalid broker address: {reason}; write `amqp://user:password@host:port/vhost`")]
    Address {
        /// Part that is wrong.
        reason: &'static str,
    },
    /// A referenced environment variable is not set.
    #[error("environment variable `{name}` is not set")]
    Variable {
        /// Name of the variable.
        name: String,
    },
    /// A credentials file cannot be read.
    #[error("no credentials in `{path}`: {reason}")]
    File {
        /// Path of the file.
        path: String,
        /// Error of the operating system.
        reason: String,
    },
}

impl AmqpSettings {
    /// Parses `amqp://user:password@host:port/vhost`. Defaults: user and password `guest`, port 5672, virtual host `/`.
    /// With `amqps` the link is encrypted, and the default port is 5671.
    ///
    /// # Errors
    /// [`AddressError::Address`] with the part that is wrong: the scheme, the credentials, the port or an escape.
    pub fn parse(address: &str) -> Result<Self, AddressError> {
        let wrong = |reason| AddressError::Address { reason };
        let (scheme, rest) = address.split_once("://").unwrap_or_default();
        let (tls, usual_port) = match scheme {
            "amqp" => (None, 5672),
            "amqps" => (Some(TlsSettings::default()), 5671),
            _ => return Err(wrong("unknown scheme")),
        };
        let (authority, vhost) = match rest.split_once('/') {
            Some((authority, vhost)) if !vhost.is_empty() => (authority, percent_decoded(vhost)?),
            Some((authority, _)) => (authority, "/".to_owned()),
            None => (rest, "/".to_owned()),
        };
        let (credentials, place) = match authority.rsplit_once('@') {
            Some((who, place)) => {
                let (user, password) = who.split_once(':').ok_or(wrong("missing password"))?;
                (
                    Credentials::new(percent_decoded(user)?, percent_decoded(password)?),
                    place,
                )
            }
            None => (Credentials::new(GUEST, GUEST), authority),
        };
        let (host, port) = match place.rsplit_once(':') {
            Some((host, port)) => (host, port.parse().map_err(|_| wrong("invalid port"))?),
            None => (place, usual_port),
        };
        if host.is_empty() {
            return Err(wrong("missing host"));
        }
        if vhost.len() > LONGEST || credentials.user.len() > LONGEST {
            return Err(wrong("a name has more than 255 bytes"));
        }
        Ok(Self {
            host: host.to_owned(),
            port,
            vhost,
            tls,
            credentials,
            robot: None,
            process: "asmotion".to_owned(),
            returns: false,
            exchange: "robots".to_owned(),
            clock: "wall".to_owned(),
            seed: 0,
            timing: AmqpTiming::default(),
            notices: Arc::new(|_| ()),
        })
    }

    /// Returns the broker's address without credentials.
    pub fn location(&self) -> String {
        format!("{}:{}/{}", self.host, self.port, self.vhost)
    }

    /// Warning about RabbitMQ's default login, `guest` with the password `guest`, at a broker on another machine. `None` for other
    /// logins, and for a broker on this machine. The name of the host is resolved for this, which can take as long as a connection.
    pub fn login_warning(&self) -> Option<String> {
        if self.credentials != Credentials::new(GUEST, GUEST) || self.is_on_this_machine() {
            return None;
        }
        let (location, vhost) = (self.location(), &self.vhost);
        Some(format!(
            "the login at the broker {location} is `guest` with the password `guest`, RabbitMQ's default: any client that reaches the \
             broker controls the robot. `rabbitmqctl add_user NAME PASSWORD` and `rabbitmqctl set_permissions -p {vhost} NAME '.*' '.*' '.*'` \
             make another one for the address `amqp://NAME@…`, and `rabbitmqctl delete_user guest` removes this one"
        ))
    }

    /// Returns whether the host is this machine: an address of a loopback interface, or a name that only has such addresses.
    fn is_on_this_machine(&self) -> bool {
        let host = self.host.trim_start_matches('[').trim_end_matches(']');
        if let Ok(address) = host.parse::<IpAddr>() {
            return address.to_canonical().is_loopback();
        }
        if host.eq_ignore_ascii_case("localhost") {
            return true;
        }
        let addresses: Vec<_> = match (host, self.port).to_socket_addrs() {
            Ok(addresses) => addresses.collect(),
            Err(_) => return false,
        };
        !addresses.is_empty() && addresses.iter().all(|it| it.ip().is_loopback())
    }

    /// Name of the direct exchange for requests.
    pub(crate) fn services(&self) -> String {
        format!("{}.services", self.exchange)
    }
}

impl fmt::Debug for AmqpSettings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} at {} as {:?}",
            self.process,
            self.location(),
            self.credentials
        )
    }
}

/// Decodes percent-encoding such as `%2F`.
fn percent_decoded(text: &str) -> Result<String, AddressError> {
    let wrong = AddressError::Address {
        reason: "`%` is followed by two hexadecimal digits",
    };
    let mut bytes = Vec::new();
    let mut rest = text.as_bytes();
    while let [first, tail @ ..] = rest {
        rest = tail;
        if *first != b'%' {
            bytes.push(*first);
            continue;
        }
        let digits = tail.get(..2).and_then(|two| std::str::from_utf8(two).ok());
        let byte = digits.and_then(|two| u8::from_str_radix(two, 16).ok());
        bytes.push(byte.ok_or(wrong.clone())?);
        rest = &tail[2..];
    }
    String::from_utf8(bytes).map_err(|_| wrong)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_is_read_whole_or_in_part() {
        let settings = AmqpSettings::parse("amqp://ann:p%40ss@rover1:5673/cell%2F1").unwrap();
        assert_eq!(settings.location(), "rover1:5673/cell/1");
        assert_eq!(settings.credentials, Credentials::new("ann", "p@ss"));
        assert_eq!(
            AmqpSettings::parse("amqp://h").unwrap().location(),
            "h:5672//"
        );
        let encrypted = AmqpSettings::parse("amqps://h").unwrap();
        assert_eq!(
            (encrypted.location(), encrypted.tls),
            ("h:5671//".into(), Some(TlsSettings::default()))
        );
        for wrong in [
            "http://h",
            "amqp://",
            "amqp://h:port",
            "amqp://a@h",
            "amqp://h/%2",
        ] {
            assert!(AmqpSettings::parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn the_default_login_is_dangerous_at_a_broker_on_another_machine() {
        let warning = |address: &str| AmqpSettings::parse(address).unwrap().login_warning();
        for address in [
            "amqp://192.0.2.7",
            "amqp://guest:guest@192.0.2.7:5673/cell",
            "amqps://guest:guest@[2001:db8::1]:5671",
            "amqp://guest:guest@127.0.0.1.invalid",
        ] {
            let warning = warning(address).expect(address);
            assert!(warning.contains("rabbitmqctl add_user"), "{warning}");
        }
        let cell = warning("amqp://192.0.2.7:5673/cell").unwrap();
        assert!(cell.contains("192.0.2.7:5673/cell") && cell.contains("-p cell NAME"));
        for address in [
            "amqp://127.0.0.1",
            "amqp://guest:guest@127.8.9.1",
            "amqp://[::1]:5672",
            "amqp://[::ffff:127.0.0.1]:5672",
            "amqp://LocalHost",
            "amqp://guest:other@192.0.2.7",
            "amqp://ann:guest@192.0.2.7",
        ] {
            assert_eq!(warning(address), None, "{address}");
        }
    }

    #[test]
    fn no_password_is_shown() {
        let settings = AmqpSettings::parse("amqp://ann:secret@h").unwrap();
        let shown = format!(
            "{settings:?} {:?} {}",
            settings.credentials,
            settings.location()
        );
        assert!(!shown.contains("secret"), "{shown}");
    }
}
