//! `asmotion component`: who is there on a broker, how they are, and what they shall do.

use super::run::property_value;
use crate::broker::{self, Broker};
use crate::exit::Exit;
use crate::table;
use crate::terminal::{NAME, Terminal};
use amqp::AmqpBus;
use asm_lang::source::similar;
use assembly::order::{Order, Wish, control_address};
use assembly::presence::{Presence, Present, Typed};
use bus::{Bell, Bus, CallFailure, Origin, Payload, Request};
use clap::{Args, Subcommand};
use datum::Datum;
use std::sync::Arc;
use std::time::Duration;

/// Shows the components that are there on a broker, starts and stops them.
#[derive(Args)]
pub struct Component {
    #[command(flatten)]
    broker: Broker,

    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    /// All components: process, state, rate
    List,
    /// One component: ports, services, references, properties
    Info {
        /// Its name
        name: String,

        /// What it declares, with the shape of every port and operation, as JSON
        #[arg(long)]
        json: bool,
    },
    /// Configures a component that has been cleaned up, or anew
    Configure {
        /// Its name
        name: String,
    },
    /// Starts a component that is stopped
    Start {
        /// Its name
        name: String,
    },
    /// Stops a component
    Stop {
        /// Its name
        name: String,
    },
    /// Has a component that is stopped give everything back
    Cleanup {
        /// Its name
        name: String,
    },
    /// Leads a component out of an exception
    Reset {
        /// Its name
        name: String,
    },
    /// Sets properties of a component, all or none, from its next cycle on
    Set {
        /// Its name
        name: String,

        /// `PROPERTY=VALUE`
        #[arg(required = true, value_name = "PROPERTY=VALUE")]
        values: Vec<String>,
    },
}

/// How long an order may take.
const PATIENCE: Duration = Duration::from_secs(10);

/// A component and where it is.
pub(super) struct Found {
    robot: String,
    process: String,
    component: Present,
}

impl Component {
    /// Does it.
    pub fn run(self, terminal: &mut Terminal) -> Exit {
        let done = self.broker.connect().and_then(|bus| {
            let found = find(&bus)?;
            match self.what {
                What::List => list(&found, terminal),
                What::Info { name, json: false } => show(named(&name, &found)?, terminal),
                What::Info { name, json: true } => {
                    let declared = order(&bus, named(&name, &found)?, Wish::Describe)?;
                    let text = datum::json::encode_pretty(&declared);
                    terminal.result(text.map_err(|error| error.to_string())?);
                }
                What::Configure { name } => done(&bus, &name, &found, Wish::Configure)?,
                What::Start { name } => done(&bus, &name, &found, Wish::Start)?,
                What::Stop { name } => done(&bus, &name, &found, Wish::Stop)?,
                What::Cleanup { name } => done(&bus, &name, &found, Wish::Cleanup)?,
                What::Reset { name } => done(&bus, &name, &found, Wish::Reset)?,
                What::Set { name, values } => {
                    let values = values.iter().map(|value| setting(value));
                    let wish = Wish::Set(values.collect::<Result<_, _>>()?);
                    done(&bus, &name, &found, wish)?;
                }
            }
            Ok(())
        });
        match done {
            Ok(()) => Exit::Ok,
            Err(problem) => {
                terminal.error(problem);
                Exit::Usage
            }
        }
    }
}

/// All components that are there.
pub(super) fn find(bus: &AmqpBus) -> Result<Vec<Found>, String> {
    let presences = broker::presences(bus).map_err(|error| error.to_string())?;
    let of = |((robot, process), presence): ((String, String), Presence)| {
        presence.components.into_iter().map(move |component| Found {
            robot: robot.clone(),
            process: process.clone(),
            component,
        })
    };
    Ok(presences.into_iter().flat_map(of).collect())
}

/// The component of a name; before it may stand its robot, `rover1.RoverDriver`.
pub(super) fn named<'f>(name: &str, found: &'f [Found]) -> Result<&'f Found, String> {
    let whole = |it: &Found| format!("{}.{}", it.robot, it.component.name);
    let named: Vec<_> = found
        .iter()
        .filter(|it| it.component.name == name || whole(it) == name)
        .collect();
    match named.as_slice() {
        [one] => Ok(one),
        [] => {
            let known = found.iter().map(|it| &it.component.name);
            let meant = similar(name, known).map(|name| format!("; did you mean `{name}`?"));
            let meant = meant.unwrap_or_default();
            Err(format!("no component `{name}` is there{meant}"))
        }
        several => {
            let several: Vec<_> = several.iter().map(|it| whole(it)).collect();
            Err(format!("which `{name}`? {}", several.join(", ")))
        }
    }
}

fn setting(written: &str) -> Result<(String, Datum), String> {
    let (property, value) = written
        .split_once('=')
        .ok_or_else(|| format!("`{written}` is not of the form PROPERTY=VALUE"))?;
    Ok((property.trim().to_owned(), property_value(value.trim())))
}

/// Has an order carried out that has no answer.
fn done(bus: &AmqpBus, name: &str, found: &[Found], wish: Wish) -> Result<(), String> {
    order(bus, named(name, found)?, wish).map(drop)
}

/// Has a component's process carry out an order, and says what it answers.
pub(super) fn order(bus: &AmqpBus, found: &Found, wish: Wish) -> Result<Datum, String> {
    let component = found.component.name.clone();
    let order = Datum::of(&Order { component, wish }).map_err(|error| error.to_string())?;
    let address = broker::key(&found.robot, &control_address(&found.process));
    let origin = Origin::new("asmotion-tool", 0);
    let request = Request::new(origin, Payload::of(order), PATIENCE);
    let pending =
        (bus.call(&address, request, Arc::new(Bell::new()))).map_err(|error| error.to_string())?;
    match pending.wait() {
        Ok(answer) => answer.to_datum().map_err(|error| error.to_string()),
        Err(CallFailure::Refused(refusal)) => Err(refusal.detail),
        Err(failure) => Err(failure.to_string()),
    }
}

fn list(found: &[Found], terminal: &mut Terminal) {
    let rows = found.iter().map(|found| {
        let component = &found.component;
        vec![
            component.name.clone(),
            found.robot.clone(),
            found.process.clone(),
            component.state.clone(),
            format!("{:.1}", component.rate_hz),
            component.overruns.to_string(),
        ]
    });
    let head = ["component", "robot", "process", "state", "Hz", "overruns"];
    for line in table::lines(&head, rows) {
        terminal.result(line);
    }
}

fn show(found: &Found, terminal: &mut Terminal) {
    let component = &found.component;
    terminal.result(format_args!(
        "{NAME}{}{NAME:#}: {} in process {} of {}",
        component.name, component.state, found.process, found.robot
    ));
    terminal.result(format_args!(
        "  cycles      {}, {:.1} a second, {} periods missed",
        component.cycles, component.rate_hz, component.overruns
    ));
    if component.dropped + component.misfits > 0 {
        terminal.result(format_args!(
            "  lost        {} messages dropped, {} did not fit",
            component.dropped, component.misfits
        ));
    }
    let mut typed = |what: &str, all: &[Typed]| {
        for Typed { name, kind } in all {
            terminal.result(format_args!("  {what:<10}  {name}: {kind}"));
        }
    };
    typed("input", &component.inputs);
    typed("output", &component.outputs);
    typed("reference", &component.references);
    for service in &component.services {
        for operation in &service.operations {
            terminal.result(format_args!(
                "  operation   {}.{}.{}: {} -> {}",
                component.name, service.name, operation.name, operation.request, operation.response
            ));
        }
    }
    for (property, value) in &component.properties {
        terminal.result(format_args!("  property    {property} = {value}"));
    }
}
