//! Brokers: settings from an address and the command line, and connections.

#[cfg(not(feature = "amqp"))]
mod left_out;
#[cfg(feature = "amqp")]
mod rabbitmq;

#[cfg(not(feature = "amqp"))]
use left_out as amqp;
#[cfg(feature = "amqp")]
use rabbitmq as amqp;

pub use amqp::AmqpSettings;
#[cfg(feature = "amqp")]
pub use rabbitmq::BrokerArguments;

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use asmotion_bus::{Bus, BusError};
use asmotion_remote::Remote;

use crate::build::Build;
use crate::transport::{BrokerAccess, BrokerAddress, ConnectTransport};

/// Name of a process that is not part of a system: it inspects systems.
const TOOL: &str = "asmotion-tool";

/// A broker, and how to reach it.
#[derive(Clone, Debug)]
pub enum BrokerSettings {
    /// RabbitMQ.
    Amqp(Box<AmqpSettings>),
    /// A broker whose transport the program has added.
    Added(Box<AddedBroker>),
}

impl BrokerSettings {
    /// Returns the settings for an address of the command line.
    ///
    /// # Errors
    /// Fails if the address is invalid or there is no password.
    pub fn of_address(build: &Build, address: &str, access: &BrokerAccess) -> Result<Self, String> {
        match Self::added(build, address, None, access) {
            Some(added) => Ok(added),
            None => Ok(Self::Amqp(Box::new(amqp::settings(address, access)?))),
        }
    }

    /// Returns the settings of a broker named in a composite.
    ///
    /// # Errors
    /// Fails if its address is invalid or contradicts `tls`, or if there is no password.
    pub fn named(
        build: &Build,
        broker: &asmotion_plan::Broker,
        access: &BrokerAccess,
    ) -> Result<Self, String> {
        let url = broker.url.as_ref();
        let url = url.map_or("", asmotion_plan::Endpoint::reveal);
        match Self::added(build, url, Some(broker), access) {
            Some(added) => Ok(added),
            None => Ok(Self::Amqp(Box::new(amqp::named(broker, access)?))),
        }
    }

    fn added(
        build: &Build,
        url: &str,
        broker: Option<&asmotion_plan::Broker>,
        access: &BrokerAccess,
    ) -> Option<Self> {
        let connect = build.transports().of_address(url)?;
        let address = BrokerAddress {
            url: url.to_owned(),
            broker: broker.cloned(),
            robot: None,
            process: TOOL.to_owned(),
            access: access.clone(),
        };
        Some(Self::Added(Box::new(AddedBroker { connect, address })))
    }

    /// Completes the settings of a run: sets the robot name, and reports changes of the link to the user unless `quiet`.
    pub fn prepare(&mut self, robot: Option<String>, quiet: bool) {
        match self {
            Self::Amqp(settings) => amqp::prepare(settings, robot, quiet),
            Self::Added(added) => added.address.robot = robot,
        }
    }

    /// Returns why the login is dangerous, and the way out, if it is: RabbitMQ's default one on another machine.
    pub fn login_warning(&self) -> Option<String> {
        match self {
            Self::Amqp(settings) => amqp::login_warning(settings),
            Self::Added(_) => None,
        }
    }

    /// Returns the name of the robot on the broker; `None` for the default.
    pub fn robot(&self) -> Option<&str> {
        match self {
            Self::Amqp(settings) => amqp::robot(settings),
            Self::Added(added) => added.address.robot.as_deref(),
        }
    }

    /// Returns what identifies the broker, and what separates topics on it, on all machines that reach it by the same address.
    #[cfg(feature = "ros")]
    pub fn place(&self) -> String {
        match self {
            Self::Amqp(settings) => amqp::place(settings),
            Self::Added(added) => on_this_machine(&added.location()),
        }
    }

    /// Connects to the broker for a process of a robot, within a limit of time if the transport permits. Returns the broker's
    /// address and the bus.
    ///
    /// # Errors
    /// Fails if the broker is unreachable or refuses the credentials.
    pub fn connect(
        &self,
        robot: &str,
        process: Option<&str>,
        limit: Duration,
    ) -> (String, Result<Arc<dyn Bus>, BusError>) {
        match self {
            Self::Amqp(settings) => amqp::connect(settings, robot, process, limit),
            Self::Added(added) => {
                let bus = added.connect(Some(robot), process.unwrap_or(robot));
                (added.location(), bus)
            }
        }
    }

    /// Connects to all systems on the broker, for a tool. Returns the broker's address too.
    ///
    /// # Errors
    /// Fails if the broker is unreachable or refuses the credentials.
    pub fn watch(&self) -> (String, Result<Remote, String>) {
        match self {
            Self::Amqp(settings) => amqp::watch(settings),
            Self::Added(added) => {
                let tool = AddedBroker {
                    address: BrokerAddress {
                        robot: None,
                        ..added.address.clone()
                    },
                    ..AddedBroker::clone(added)
                };
                let location = added.location();
                let bus = tool.connect(None, TOOL);
                let bus = bus.map_err(|reason| format!("broker at {location}: {reason}"));
                let remote = bus
                    .and_then(|bus| Remote::over_bus(bus, None).map_err(|error| error.to_string()));
                (location, remote)
            }
        }
    }
}

/// The address of a broker with the name of this machine, in place of names that every machine has.
#[cfg(feature = "ros")]
fn on_this_machine(address: &str) -> String {
    let machine = || {
        let files = ["/etc/machine-id", "/proc/sys/kernel/hostname"];
        let found = files.iter().find_map(|it| std::fs::read_to_string(it).ok());
        found.unwrap_or_default().trim().to_owned()
    };
    let local = ["localhost", "127.0.0.1", "[::1]"];
    match local.iter().find(|it| address.contains(**it)) {
        Some(host) => address.replacen(host, &machine(), 1),
        None => address.to_owned(),
    }
}

/// Settings of a broker whose transport a program has added.
#[derive(Clone)]
pub struct AddedBroker {
    connect: ConnectTransport,
    address: BrokerAddress,
}

impl AddedBroker {
    /// The address without a password, for messages.
    fn location(&self) -> String {
        let url = &self.address.url;
        let parts = url.split_once("://").and_then(|(scheme, rest)| {
            let (user, host) = rest.split_once('@')?;
            let user = user.split(':').next().unwrap_or(user);
            Some(format!("{scheme}://{user}@{host}"))
        });
        parts.unwrap_or_else(|| url.clone())
    }

    fn connect(&self, robot: Option<&str>, process: &str) -> Result<Arc<dyn Bus>, BusError> {
        let mut address = self.address.clone();
        address.robot = address.robot.or(robot.map(str::to_owned));
        process.clone_into(&mut address.process);
        (self.connect)(&address)
    }
}

impl fmt::Debug for AddedBroker {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("AddedBroker")
            .field(&self.location())
            .finish()
    }
}
