//! `asmotion port`: reads and writes ports of live components.

use crate::broker::BrokerArguments;
use crate::build::Build;
use crate::exit::Exit;
use crate::terminal::TerminalOutput;
use asmotion_datum::Datum;
use asmotion_remote::RemoteError;
use clap::{Args, Subcommand};

/// Reads output ports and writes input ports of live components.
#[derive(Args)]
pub struct Port {
    #[command(flatten)]
    broker: BrokerArguments,

    #[command(subcommand)]
    what: PortCommand,
}

#[derive(Subcommand)]
enum PortCommand {
    /// Prints the last value written to an output port, as JSON
    Read {
        /// `COMPONENT.PORT`, or `ROBOT.COMPONENT.PORT`
        port: String,
    },
    /// Writes a message to an input port after checking it against the port's type
    Write {
        /// `COMPONENT.PORT`, or `ROBOT.COMPONENT.PORT`
        port: String,

        /// Message as JSON; omitted fields have their default values
        message: String,
    },
}

impl Port {
    pub fn run(self, build: &Build, terminal: &mut TerminalOutput) -> Exit {
        match self.execute(build) {
            Ok(None) => Exit::Ok,
            Ok(Some(read)) => {
                terminal.result(read);
                Exit::Ok
            }
            Err(problem) => {
                terminal.error(problem);
                Exit::Usage
            }
        }
    }

    fn execute(self, build: &Build) -> Result<Option<String>, String> {
        let (whole, message) = match self.what {
            PortCommand::Read { port } => (port, None),
            PortCommand::Write { port, message } => {
                let datum: Datum = asmotion_datum::json::decode(&message)
                    .map_err(|error| format!("`{message}` is not JSON: {error}"))?;
                (port, Some(datum))
            }
        };
        let (component, port) = whole
            .rsplit_once('.')
            .ok_or_else(|| format!("`{whole}` is not a port: write `Component.port`"))?;
        let remote = self.broker.remote(build)?;
        let result = remote
            .component(component)
            .and_then(|component| match message {
                Some(message) => component.write(port, message).map(|()| None),
                None => {
                    let read: Datum = component.read(port)?;
                    Ok(Some(asmotion_datum::json::encode(&read)?))
                }
            });
        result.map_err(|error: RemoteError| error.to_string())
    }
}
