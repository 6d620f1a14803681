//! Broker options of the command line: address and credentials.

#[cfg(not(feature = "amqp"))]
mod left_out;
#[cfg(feature = "amqp")]
mod rabbitmq;

#[cfg(not(feature = "amqp"))]
pub use left_out::*;
#[cfg(feature = "amqp")]
pub use rabbitmq::*;

use std::ffi::OsString;
use std::path::PathBuf;

use clap::Args;

/// Credentials for a broker.
#[derive(Args, Clone, Default)]
pub struct BrokerAccess {
    /// Credentials for the broker: a file with the user on the first line and the password on the second
    #[arg(long, global = true, value_name = "FILE")]
    credentials: Option<PathBuf>,

    /// For `amqps`: certificate of the authority that signed the broker's certificate (PEM) [default: the web's
    /// authorities]
    #[arg(long, global = true, value_name = "FILE")]
    ca: Option<PathBuf>,

    /// Client certificate (PEM), if the broker demands one
    #[arg(long, global = true, value_name = "FILE", requires = "key")]
    certificate: Option<PathBuf>,

    /// Private key of the client certificate (PEM)
    #[arg(long, global = true, value_name = "FILE", requires = "certificate")]
    key: Option<PathBuf>,
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
