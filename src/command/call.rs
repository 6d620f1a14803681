//! `asmotion call`: calls an operation of a live component.

use crate::broker::{self, Broker};
use crate::exit::Exit;
use crate::terminal::Terminal;
use amqp::AmqpBus;
use asm_lang::source::similar;
use bus::{Bell, Bus, CallFailure, Origin, Payload, Request};
use clap::Args;
use datum::Datum;
use std::sync::Arc;
use std::time::Duration;

/// Calls an operation of a live component.
#[derive(Args)]
pub struct Call {
    /// The operation: `navigation.TrajectoryPlanner.planning.plan`, that is robot, component, service,
    /// operation.
    operation: String,

    /// What is asked, as JSON; fields left out have their initial values.
    #[arg(default_value = "{}")]
    argument: String,

    /// Gives up after so many seconds.
    #[arg(long, value_name = "SECONDS", default_value_t = 5.0)]
    timeout: f64,

    #[command(flatten)]
    broker: Broker,
}

impl Call {
    /// Calls, and shows the answer as JSON.
    pub fn run(self, terminal: &mut Terminal) -> Exit {
        let called = self.call();
        let (bus, end) = match called {
            Ok(called) => called,
            Err(problem) => {
                terminal.error(problem);
                return Exit::Usage;
            }
        };
        let answer = end.and_then(|payload| {
            let unreadable = |error: datum::DatumError| bus::Refusal {
                code: "BAD_REPLY".to_owned(),
                detail: error.to_string(),
            };
            let text = (payload.to_datum()).and_then(|datum| datum::json::encode_pretty(&datum));
            Ok(text.map_err(unreadable)?)
        });
        match answer {
            Ok(text) => {
                terminal.result(text);
                Exit::Ok
            }
            Err(CallFailure::Unavailable) => {
                terminal.error(self.nobody(&bus));
                Exit::Findings
            }
            Err(failure) => {
                terminal.error(failure);
                Exit::Findings
            }
        }
    }

    fn call(&self) -> Result<(AmqpBus, Result<Payload, CallFailure>), String> {
        let argument: Datum = datum::json::decode(&self.argument)
            .map_err(|error| format!("`{}` is no JSON: {error}", self.argument))?;
        let timeout = Duration::try_from_secs_f64(self.timeout)
            .map_err(|error| format!("`--timeout {}`: {error}", self.timeout))?;
        let bus = self.broker.connect()?;
        let origin = Origin::new("asmotion-tool", 0);
        let request = Request::new(origin, Payload::of(argument), timeout);
        let pending = (bus.call(&self.operation, request, Arc::new(Bell::new())))
            .map_err(|error| error.to_string())?;
        let end = pending.wait();
        Ok((bus, end))
    }

    /// Nobody serves there; perhaps another name was meant.
    fn nobody(&self, bus: &AmqpBus) -> String {
        let mut known = Vec::new();
        for ((robot, _), presence) in broker::presences(bus).unwrap_or_default() {
            for component in presence.components {
                for service in component.services {
                    let path = format!("{robot}.{}.{}", component.name, service.name);
                    let operations = service.operations.into_iter();
                    known.extend(operations.map(|operation| format!("{path}.{}", operation.name)));
                }
            }
        }
        let meant = similar(&self.operation, &known);
        let meant = meant.map(|name| format!("; did you mean `{name}`?"));
        let meant = meant.unwrap_or_default();
        format!("nobody serves `{}`{meant}", self.operation)
    }
}
