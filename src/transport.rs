//! Transports that a program adds to RabbitMQ, and what they need to connect.

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::Arc;

use asmotion_bus::{Bus, BusError};
use clap::Args;

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
    pub(crate) fn of_address(&self, address: &str) -> Option<ConnectTransport> {
        let (scheme, _) = address.split_once("://")?;
        let row = self.0.iter().find(|(known, _)| *known == scheme)?;
        Some(row.1)
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
