//! Brokers: settings from an address and the command line, and connections.

#[cfg(not(feature = "amqp"))]
mod left_out;
#[cfg(feature = "amqp")]
mod rabbitmq;
mod transport;

#[cfg(not(feature = "amqp"))]
use left_out as amqp;
#[cfg(feature = "amqp")]
use rabbitmq as amqp;

pub use amqp::AmqpSettings;
#[cfg(feature = "amqp")]
pub use rabbitmq::BrokerArguments;
pub(crate) use transport::Transports;
pub use transport::{AddedBroker, BrokerAddress, ConnectTransport};

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::Arc;

use asmotion_bus::{Bus, BusError};
#[cfg(any(feature = "amqp", feature = "tui"))]
use asmotion_remote::Remote;
use clap::Args;

use crate::app::App;

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
    pub fn of_address(app: &App, address: &str, access: &BrokerAccess) -> Result<Self, String> {
        match Self::added(app, address, None, access) {
            Some(added) => Ok(added),
            None => Ok(Self::Amqp(Box::new(amqp::settings(address, access)?))),
        }
    }

    /// Returns the settings of a broker named in a composite.
    ///
    /// # Errors
    /// Fails if its address is invalid or contradicts `tls`, or if there is no password.
    pub fn named(
        app: &App,
        broker: &asmotion_plan::Broker,
        access: &BrokerAccess,
    ) -> Result<Self, String> {
        let url = broker.url.as_ref();
        let url = url.map_or("", asmotion_plan::Endpoint::reveal);
        match Self::added(app, url, Some(broker), access) {
            Some(added) => Ok(added),
            None => Ok(Self::Amqp(Box::new(amqp::named(broker, access)?))),
        }
    }

    fn added(
        app: &App,
        url: &str,
        broker: Option<&asmotion_plan::Broker>,
        access: &BrokerAccess,
    ) -> Option<Self> {
        let connect = app.transports().of_address(url)?;
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

    /// Returns the name of the robot on the broker; `None` for the default.
    pub fn robot(&self) -> Option<&str> {
        match self {
            Self::Amqp(settings) => amqp::robot(settings),
            Self::Added(added) => added.address.robot.as_deref(),
        }
    }

    /// Connects to the broker for a process of a robot. Returns the broker's address and the bus.
    ///
    /// # Errors
    /// Fails if the broker is unreachable or refuses the credentials.
    pub fn connect(
        &self,
        robot: &str,
        process: Option<&str>,
    ) -> (String, Result<Arc<dyn Bus>, BusError>) {
        match self {
            Self::Amqp(settings) => amqp::connect(settings, robot, process),
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
    #[cfg(any(feature = "amqp", feature = "tui"))]
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

/// Credentials for a broker.
#[derive(Args, Clone, Debug, Default)]
pub struct BrokerAccess {
    /// Credentials for the broker: a file with the user on the first line and the password on the second
    #[arg(long, global = true, value_name = "FILE")]
    pub credentials: Option<PathBuf>,

    /// For `amqps`: certificate of the authority that signed the broker's certificate (PEM) [default: the web's
    /// authorities]
    #[arg(long, global = true, value_name = "FILE")]
    pub ca: Option<PathBuf>,

    /// Client certificate (PEM), if the broker demands one
    #[arg(long, global = true, value_name = "FILE", requires = "key")]
    pub certificate: Option<PathBuf>,

    /// Private key of the client certificate (PEM)
    #[arg(long, global = true, value_name = "FILE", requires = "certificate")]
    pub key: Option<PathBuf>,
}

impl BrokerAccess {
    /// The equivalent command-line arguments.
    pub fn arguments(&self) -> Vec<OsString> {
        let all = [
            ("--credentials", &self.credentials),
            ("--ca", &self.ca),
            ("--certificate", &self.certificate),
            ("--key", &self.key),
        ];
        let given = all
            .into_iter()
            .filter_map(|(key, file)| Some((key, file.as_ref()?)));
        given
            .flat_map(|(key, file)| [key.into(), file.into()])
            .collect()
    }
}
