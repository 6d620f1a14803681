//! RabbitMQ: settings from an address and the command line, and connections.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use asmotion_amqp::{AmqpBus, ClientIdentity, Credentials};
use asmotion_bus::{Bus, BusError};
use asmotion_composite::model::Tls;
use asmotion_remote::Remote;
use clap::Args;

use super::{BrokerSettings, TOOL};
use crate::build::Build;
use crate::terminal::print_progress;
use crate::transport::BrokerAccess;

pub use asmotion_amqp::AmqpSettings;

/// Time limit for the first connection.
const CONNECT: Duration = Duration::from_secs(10);

/// Environment variable with the password.
const PASSWORD: &str = "ASMOTION_PASSWORD";

/// Options of commands that use a live broker.
#[derive(Args, Clone)]
pub struct BrokerArguments {
    /// Address of the broker, `amqp://user@host:port/vhost` [default: the environment variable ASMOTION_BUS]. The
    /// password is read from ASMOTION_PASSWORD or `--credentials`.
    #[arg(long, global = true, value_name = "URL")]
    bus: Option<String>,

    #[command(flatten)]
    access: BrokerAccess,
}

impl BrokerArguments {
    /// Returns the connection settings. Topics and addresses are whole keys, including the robot's name.
    ///
    /// # Errors
    /// Fails if no broker is given or the password is unknown.
    pub fn settings(&self, build: &Build) -> Result<BrokerSettings, String> {
        let variable = || std::env::var("ASMOTION_BUS").ok();
        let address = self.bus.clone().or_else(variable).ok_or(
            "no broker selected: add `--bus amqp://user@host:port/vhost`, or set ASMOTION_BUS",
        )?;
        let mut settings = BrokerSettings::of_address(build, &address, &self.access)?;
        if let BrokerSettings::Amqp(settings) = &mut settings {
            TOOL.clone_into(&mut settings.process);
        }
        Ok(settings)
    }

    /// Connects to the broker to inspect the systems on it.
    ///
    /// # Errors
    /// Fails if the broker is unreachable or refuses the connection.
    pub fn remote(&self, build: &Build) -> Result<Remote, String> {
        self.settings(build)?.watch().1
    }
}

fn remote(mut settings: AmqpSettings) -> Result<Remote, String> {
    settings.process = TOOL.to_owned();
    let location = settings.location();
    let bus = AmqpBus::connect(settings, CONNECT).map_err(|reason| {
        format!("broker at {location}: {reason}\n  `asmotion doctor` shows how to fix it")
    })?;
    Remote::over_bus(Arc::new(bus), None).map_err(|error| error.to_string())
}

/// Time before a notice that repeats the one before is printed again.
const REPEATED: Duration = Duration::from_secs(30);

/// Completes the settings of a run: sets the robot name, and reports changes of the link to the user unless `quiet`.
pub fn prepare(settings: &mut AmqpSettings, robot: Option<String>, quiet: bool) {
    settings.robot = robot;
    if !quiet {
        let last = Mutex::new(None);
        settings.notices = Arc::new(move |notice| {
            let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
            if is_news(&mut last, notice.to_string(), Instant::now()) {
                print_progress(format_args!("         Bus {notice}"));
            }
        });
    }
}

/// Returns whether a notice differs from the last one that was printed, or comes [`REPEATED`] after it: a link that is down
/// reports every attempt to connect.
fn is_news(last: &mut Option<(String, Instant)>, notice: String, now: Instant) -> bool {
    let is_repeated = |(printed, at): &(String, Instant)| {
        *printed == notice && now.saturating_duration_since(*at) < REPEATED
    };
    let is_news = !last.as_ref().is_some_and(is_repeated);
    if is_news {
        *last = Some((notice, now));
    }
    is_news
}

/// Returns why the login is dangerous, if it is.
pub fn login_warning(settings: &AmqpSettings) -> Option<String> {
    settings.login_warning()
}

/// Returns the name of the robot in the settings; `None` for the default.
pub fn robot(settings: &AmqpSettings) -> Option<&str> {
    settings.robot.as_deref()
}

/// Returns what identifies a broker, and its exchange.
#[cfg(feature = "ros")]
pub fn place(settings: &AmqpSettings) -> String {
    let location = super::on_this_machine(&settings.location());
    format!("{location} {}", settings.exchange)
}

/// Connects to a broker for a process of a robot, within a limit of time. Returns the broker's address and the bus.
///
/// # Errors
/// Fails if the broker is unreachable or refuses the credentials.
pub fn connect(
    settings: &AmqpSettings,
    robot: &str,
    process: Option<&str>,
    limit: Duration,
) -> (String, Result<Arc<dyn Bus>, BusError>) {
    let mut settings = settings.clone();
    settings.robot.get_or_insert_with(|| robot.to_owned());
    settings.returns = true;
    if let Some(process) = process {
        process.clone_into(&mut settings.process);
    }
    let location = settings.location();
    let bus = AmqpBus::connect(settings, limit);
    (location, bus.map(|bus| Arc::new(bus) as Arc<dyn Bus>))
}

/// Connects to all systems on a broker, for a tool. Returns the broker's address too.
///
/// # Errors
/// Fails if the broker is unreachable or refuses the credentials.
pub fn watch(settings: &AmqpSettings) -> (String, Result<Remote, String>) {
    let mut settings = settings.clone();
    settings.robot = None;
    (settings.location(), remote(settings))
}

/// Returns the settings of a broker named in a composite.
///
/// # Errors
/// Fails if its address is invalid or contradicts `tls`, or if there is no password.
pub fn named(
    broker: &asmotion_plan::Broker,
    access: &BrokerAccess,
) -> Result<AmqpSettings, String> {
    let of = |reason: String| format!("broker `{}` of the composite: {reason}", broker.name);
    let address = broker
        .url
        .as_ref()
        .map_or("", asmotion_plan::Endpoint::reveal);
    let address = match broker.tls {
        Tls::Prefer => address.to_owned(),
        Tls::Require => address.replacen("amqp://", "amqps://", 1),
        Tls::Off if address.starts_with("amqps://") => {
            return Err(of(
                "`tls = \"off\"`, but the address begins with `amqps`".to_owned()
            ));
        }
        Tls::Off => address.to_owned(),
    };
    let mut settings = settings(&address, access).map_err(of)?;
    settings.exchange.clone_from(&broker.exchange);
    settings.timing.heartbeat = u16::try_from(broker.heartbeat_s).unwrap_or(u16::MAX);
    settings.timing.first_retry = Duration::from_millis(broker.reconnect.first_ms);
    settings.timing.last_retry = Duration::from_millis(broker.reconnect.max_ms);
    settings.timing.jitter = broker.reconnect.jitter;
    Ok(settings)
}

/// Returns the settings for `amqp://user@host:port/vhost`. The password is read from the credentials file or the
/// environment. A password in the address is accepted, although other users can see it in the process list.
///
/// # Errors
/// Fails if the address is invalid or there is no password.
pub fn settings(address: &str, access: &BrokerAccess) -> Result<AmqpSettings, String> {
    let (address, has_password) = with_password(address);
    let mut settings = AmqpSettings::parse(&address).map_err(|error| error.to_string())?;
    if let Some(tls) = &mut settings.tls {
        tls.authority.clone_from(&access.ca);
        let identity = access.certificate.clone().zip(access.key.clone());
        tls.identity = identity.map(|(certificate, key)| ClientIdentity { certificate, key });
    }
    if let Some(file) = &access.credentials {
        settings.credentials = Credentials::from_file(file).map_err(|error| error.to_string())?;
    } else if !has_password {
        let user = settings.credentials.user().to_owned();
        let password = std::env::var(PASSWORD).map_err(|_| {
            format!(
                "missing password of `{user}`: set {PASSWORD}, or name a file with `--credentials`"
            )
        })?;
        settings.credentials = Credentials::new(user, password);
    }
    Ok(settings)
}

/// Returns the address with a password, and whether that password belongs to the user. An address without a user gets
/// RabbitMQ's default user, `guest`.
fn with_password(address: &str) -> (String, bool) {
    let user = address.split_once("://").and_then(|(scheme, rest)| {
        let authority = rest.split('/').next().unwrap_or(rest);
        let (user, _) = authority.rsplit_once('@')?;
        let after = rest.get(user.len()..)?;
        (!user.contains(':')).then(|| format!("{scheme}://{user}:{after}"))
    });
    match user {
        Some(address) => (address, false),
        None => (address.to_owned(), true),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asmotion_composite::model::PlannedReconnect;

    #[test]
    fn heartbeat_and_reconnection_of_a_composite_s_broker_are_those_of_the_connection() {
        let address = "amqp://ann:secret@h";
        let broker = asmotion_plan::Broker {
            name: "main".to_owned(),
            url: Some(asmotion_plan::Endpoint::new(address, address)),
            exchange: "robots".to_owned(),
            codec: Default::default(),
            tls: Tls::Prefer,
            heartbeat_s: 9,
            reconnect: PlannedReconnect {
                first_ms: 7,
                max_ms: 70,
                jitter: 0.25,
            },
        };
        let timing = named(&broker, &BrokerAccess::default()).unwrap().timing;
        assert_eq!(timing.heartbeat, 9);
        assert_eq!(timing.first_retry, Duration::from_millis(7));
        assert_eq!(timing.last_retry, Duration::from_millis(70));
        assert_eq!(timing.jitter, 0.25);
    }

    #[test]
    fn a_user_without_password_keeps_name_and_place() {
        let (address, has_password) = with_password("amqp://ann@rover1:5673/cell");
        assert_eq!(address, "amqp://ann:@rover1:5673/cell");
        assert!(!has_password);
        for whole in ["amqp://ann:secret@h", "amqp://h:5672/v", "local"] {
            assert_eq!(with_password(whole), (whole.to_owned(), true));
        }
    }

    #[test]
    fn credentials_of_a_file_count() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("credentials");
        std::fs::write(&file, "bob\nsecret\n").unwrap();
        let access = BrokerAccess {
            credentials: Some(file),
            ..BrokerAccess::default()
        };
        let settings = settings("amqp://ann@h", &access).unwrap();
        assert_eq!(settings.credentials, Credentials::new("bob", "secret"));
    }

    #[test]
    fn a_notice_is_printed_once_in_half_a_minute() {
        let (mut last, begin) = (None, Instant::now());
        let mut printed = Vec::new();
        for (second, notice) in [
            (0, "down"),
            (1, "down"),
            (2, "up"),
            (3, "down"),
            (33, "down"),
        ] {
            if is_news(
                &mut last,
                notice.to_owned(),
                begin + Duration::from_secs(second),
            ) {
                printed.push(second);
            }
        }
        assert_eq!(printed, [0, 2, 3, 33]);
    }
}
