//! Transports that a program adds to RabbitMQ.

use std::fmt;
use std::sync::Arc;

use asmotion_bus::{Bus, BusError};

use super::BrokerAccess;

/// Connects a process to a broker. Called in the thread that starts the process, which waits for the result.
pub type ConnectTransport = fn(&BrokerAddress) -> Result<Arc<dyn Bus>, BusError>;

/// A broker and the process that connects to it.
#[derive(Clone, Debug)]
pub struct BrokerAddress {
    /// Address of the broker, with the scheme under which the transport is registered, for example `mqtt://host:1883`.
    pub url: String,
    /// The broker's table in the composite; `None` if the address is from the command line. A transport fails if it does not
    /// support a key that differs from its default.
    pub broker: Option<asmotion_plan::Broker>,
    /// Robot whose topics and services these are: the first word of their keys on the broker. `None` for tools, whose
    /// topics and addresses are whole keys.
    pub robot: Option<String>,
    /// Name of the process.
    pub process: String,
    /// Credentials named on the command line.
    pub access: BrokerAccess,
}

/// The transports of a program, by the scheme of their addresses.
#[derive(Clone, Debug, Default)]
pub(crate) struct Transports(Vec<(&'static str, ConnectTransport)>);

impl Transports {
    /// Adds a transport. A scheme that is taken replaces the earlier transport.
    pub(crate) fn add(&mut self, scheme: &'static str, connect: ConnectTransport) {
        self.0.retain(|(known, _)| *known != scheme);
        self.0.push((scheme, connect));
    }

    /// The transport for an address; `None` if no transport has its scheme.
    pub(super) fn of_address(&self, address: &str) -> Option<ConnectTransport> {
        let (scheme, _) = address.split_once("://")?;
        let row = self.0.iter().find(|(known, _)| *known == scheme)?;
        Some(row.1)
    }
}

/// Settings of a broker whose transport a program has added.
#[derive(Clone)]
pub struct AddedBroker {
    pub(super) connect: ConnectTransport,
    pub(super) address: BrokerAddress,
}

impl AddedBroker {
    /// The address without a password, for messages.
    pub(super) fn location(&self) -> String {
        let url = &self.address.url;
        let parts = url.split_once("://").and_then(|(scheme, rest)| {
            let (user, host) = rest.split_once('@')?;
            let user = user.split(':').next().unwrap_or(user);
            Some(format!("{scheme}://{user}@{host}"))
        });
        parts.unwrap_or_else(|| url.clone())
    }

    pub(super) fn connect(
        &self,
        robot: Option<&str>,
        process: &str,
    ) -> Result<Arc<dyn Bus>, BusError> {
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
