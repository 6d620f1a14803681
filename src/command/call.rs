//! `asmotion call`: calls an operation of a live component.

use crate::broker::BrokerArguments;
use crate::build::Build;
use crate::exit::Exit;
use crate::terminal::TerminalOutput;
use asmotion_datum::Datum;
use asmotion_remote::{RemoteError, SendHandle};
use clap::Args;
use std::time::Duration;

/// Calls an operation of a live component.
#[derive(Args)]
pub struct Call {
    /// Operation as `ROBOT.COMPONENT.SERVICE.OPERATION`, for example `navigation.TrajectoryPlanner.planning.plan`, or as
    /// `INTERFACE.OPERATION` of the only service with the interface, for example `nav/PlanService.plan`; robot and service can be
    /// omitted if this leaves one operation, as in `TrajectoryPlanner.plan` or, of a nested component, `Arm/Driver.getJoints`
    operation: String,

    /// Argument as JSON; omitted fields have their default values
    #[arg(default_value = "{}")]
    argument: String,

    /// Deadline of the call in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 5.0)]
    timeout: f64,

    #[command(flatten)]
    broker: BrokerArguments,
}

impl Call {
    /// Makes the call and prints the reply as JSON.
    pub fn run(self, build: &Build, terminal: &mut TerminalOutput) -> Exit {
        match self.call(build) {
            Ok(Ok(answer)) => {
                terminal.result(answer);
                Exit::Ok
            }
            Ok(Err(failure)) => {
                terminal.error(failure);
                Exit::Findings
            }
            Err(problem) => {
                terminal.error(problem);
                Exit::Usage
            }
        }
    }

    /// Makes the call. The outer error explains why the call could not be made, the inner one why it failed.
    fn call(&self, build: &Build) -> Result<Result<String, RemoteError>, String> {
        let argument: Datum = asmotion_datum::json::decode(&self.argument)
            .map_err(|error| format!("`{}` is not JSON: {error}", self.argument))?;
        let patience = Duration::try_from_secs_f64(self.timeout)
            .map_err(|error| format!("`--timeout {}`: {error}", self.timeout))?;
        let remote = self.broker.remote(build)?;
        let address = remote.operation_address(&self.operation);
        let address = address.map_err(|error| error.to_string())?;
        let call = |address: &str| {
            let sent = remote.send(address, argument.clone(), patience);
            sent.map(SendHandle::collect)
                .map_err(|error| error.to_string())
        };
        let mut answer = call(&address)?;
        if matches!(answer, Err(RemoteError::Nobody { .. })) {
            // nothing has this address: it may lack its robot or service
            let full = remote.short_operation_address(&address);
            if let Some(full) = full.map_err(|error| error.to_string())?
                && full != address
            {
                answer = call(&full)?;
            }
            // what is present may have become known since
            if let Err(RemoteError::Nobody { nearest, .. }) = &mut answer {
                *nearest = nearest
                    .take()
                    .or_else(|| remote.similar_operation(&address));
            }
        }
        Ok(answer.and_then(|answer| Ok(asmotion_datum::json::encode_pretty(&answer)?)))
    }
}
