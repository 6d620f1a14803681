//! `asmotion component`: who is there on a broker, and how they are.

use crate::broker::{self, Broker};
use crate::exit::Exit;
use crate::table;
use crate::terminal::{NAME, Terminal};
use asm_lang::source::similar;
use assembly::presence::{Present, Typed};
use clap::{Args, Subcommand};

/// Shows the components that are there on a broker, and how they are.
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
    },
}

/// A component and where it is.
struct Found {
    robot: String,
    process: String,
    component: Present,
}

impl Component {
    /// Does it.
    pub fn run(self, terminal: &mut Terminal) -> Exit {
        let found = match self.find() {
            Ok(found) => found,
            Err(problem) => {
                terminal.error(problem);
                return Exit::Usage;
            }
        };
        match self.what {
            What::List => {
                list(&found, terminal);
                Exit::Ok
            }
            What::Info { name } => info(&name, &found, terminal),
        }
    }

    fn find(&self) -> Result<Vec<Found>, String> {
        let bus = self.broker.connect()?;
        let presences = broker::presences(&bus).map_err(|error| error.to_string())?;
        let of =
            |((robot, process), presence): ((String, String), assembly::presence::Presence)| {
                presence.components.into_iter().map(move |component| Found {
                    robot: robot.clone(),
                    process: process.clone(),
                    component,
                })
            };
        Ok(presences.into_iter().flat_map(of).collect())
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

fn info(name: &str, found: &[Found], terminal: &mut Terminal) -> Exit {
    let named: Vec<_> = found
        .iter()
        .filter(|it| it.component.name == name)
        .collect();
    if named.is_empty() {
        let known = found.iter().map(|it| &it.component.name);
        let meant = similar(name, known).map(|name| format!("; did you mean `{name}`?"));
        let meant = meant.unwrap_or_default();
        terminal.error(format_args!("no component `{name}` is there{meant}"));
        return Exit::Usage;
    }
    for found in named {
        show(found, terminal);
    }
    Exit::Ok
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
