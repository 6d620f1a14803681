//! `asmotion component`: lists, inspects and controls live components.

mod properties;
mod types;

use self::properties::PropertiesCommand;
use self::types::DeclaredTypes;
use super::run::property_value;
use crate::broker::BrokerArguments;
use crate::build::Build;
use crate::exit::Exit;
use crate::inspection;
use crate::table;
use crate::terminal::{NAME, TerminalOutput};
use asmotion_component::{ThreadUse, Transition};
use asmotion_datum::{Datum, Word};
use asmotion_remote::{PresentComponent, PresentEndpoint, Remote, RemoteComponent};
use clap::{Args, Subcommand};
use std::error::Error;

/// Lists, inspects and controls live components on a broker.
#[derive(Args)]
pub struct Component {
    #[command(flatten)]
    broker: BrokerArguments,

    #[command(subcommand)]
    what: ComponentCommand,
}

#[derive(Subcommand)]
enum ComponentCommand {
    /// Lists all components with process, state and rate
    List {
        /// Lists only services with this interface, for example `nav/PlanService`
        #[arg(long, value_name = "INTERFACE")]
        offers: Option<String>,
    },
    /// Shows ports, services, references and properties of a component
    Info {
        /// Name of the component
        name: String,

        /// Prints the declaration as JSON, with the schema of every port and operation
        #[arg(long)]
        json: bool,
    },
    /// Configures a component that is not configured, or configures it again
    Configure {
        /// Name of the component
        name: String,
    },
    /// Starts a stopped component
    Start {
        /// Name of the component
        name: String,
    },
    /// Stops a component
    Stop {
        /// Name of the component
        name: String,
    },
    /// Cleans up a stopped component, which releases its resources
    Cleanup {
        /// Name of the component
        name: String,
    },
    /// Resets a component after an exception
    Reset {
        /// Name of the component
        name: String,
    },
    /// Sets properties of a component before its next cycle: all of them or none
    Set {
        /// Name of the component
        name: String,

        /// `PROPERTY=VALUE`
        #[arg(required = true, value_name = "PROPERTY=VALUE")]
        values: Vec<String>,
    },
    #[command(flatten)]
    Properties(PropertiesCommand),
}

impl Component {
    /// Executes the subcommand.
    pub fn run(self, build: &Build, terminal: &mut TerminalOutput) -> Exit {
        let result = self.broker.remote(build).and_then(|remote| {
            let result = self.what.run(&remote, terminal);
            result.map_err(|error| error.to_string())
        });
        match result {
            Ok(exit) => exit,
            Err(problem) => {
                terminal.error(problem);
                Exit::Usage
            }
        }
    }
}

impl ComponentCommand {
    fn run(self, remote: &Remote, terminal: &mut TerminalOutput) -> Result<Exit, Box<dyn Error>> {
        let take = |name: String, transition| remote.component(&name)?.transition(transition);
        match self {
            Self::List { offers: None } => list(&remote.components(), terminal),
            Self::List {
                offers: Some(interface),
            } => return Ok(offers(remote, &interface, terminal)),
            Self::Info { name, json: false } => {
                let component = remote.component(&name)?;
                let mut present = component.present().clone();
                if present.properties.is_empty() {
                    // it was in the middle of a cycle
                    present.properties = component.properties().unwrap_or_default();
                }
                show(&component, &present, terminal);
            }
            Self::Info { name, json: true } => {
                let declared = Datum::of(&remote.component(&name)?.declaration()?)?;
                terminal.result(asmotion_datum::json::encode_pretty(&declared)?);
            }
            Self::Configure { name } => take(name, Transition::Configure)?,
            Self::Start { name } => take(name, Transition::Start)?,
            Self::Stop { name } => take(name, Transition::Stop)?,
            Self::Cleanup { name } => take(name, Transition::Cleanup)?,
            Self::Reset { name } => take(name, Transition::ResetException)?,
            Self::Set { name, values } => {
                let values: Result<_, String> = values.iter().map(|it| setting(it)).collect();
                remote.component(&name)?.set_all(values?)?;
            }
            Self::Properties(properties) => return properties.run(remote, terminal),
        }
        Ok(Exit::Ok)
    }
}

fn setting(written: &str) -> Result<(String, Datum), String> {
    let (property, value) = written
        .split_once('=')
        .ok_or_else(|| format!("`{written}` is not of the form PROPERTY=VALUE"))?;
    Ok((property.trim().to_owned(), property_value(value.trim())))
}

pub(super) fn list(components: &[asmotion_remote::RemoteComponent], terminal: &mut TerminalOutput) {
    let rows = components.iter().map(|component| {
        let present = component.present();
        vec![
            present.name.clone(),
            component.robot().to_owned(),
            component.process().to_owned(),
            present.state.clone(),
            inspection::control_state(&present.inspection).unwrap_or_else(|| "-".to_owned()),
            format!("{:.1}", present.rate_hz),
            present.overruns.to_string(),
            present.late.to_string(),
        ]
    });
    let head = [
        "component",
        "robot",
        "process",
        "state",
        "control",
        "Hz",
        "overruns",
        "late",
    ];
    for line in table::lines(&head, rows) {
        terminal.result(line);
    }
}

/// Lists the services with an interface. One that nobody offers is an error, and two are not.
fn offers(remote: &Remote, interface: &str, terminal: &mut TerminalOutput) -> Exit {
    let found = remote.services(interface);
    if found.is_empty() {
        // `service` knows the most similar interface
        if let Err(error) = remote.service(interface) {
            terminal.error(error);
        }
        return Exit::Findings;
    }
    let rows = found.into_iter().map(|it| {
        let address = it.address();
        vec![address, it.component, it.robot, it.process, it.state]
    });
    let head = ["service", "component", "robot", "process", "state"];
    for line in table::lines(&head, rows) {
        terminal.result(line);
    }
    Exit::Ok
}

/// The thread of a component in real time.
fn thread(component: &PresentComponent) -> Option<&'static str> {
    let thread = ThreadUse::of_word(&component.thread)?;
    Some(match thread {
        ThreadUse::Own => "its own",
        ThreadUse::Shared => "an executor thread, shared with other components",
    })
}

pub(super) fn show(
    remote_component: &RemoteComponent,
    component: &PresentComponent,
    terminal: &mut TerminalOutput,
) {
    let id = if component.id.is_empty() || component.id == component.name {
        String::new()
    } else {
        format!(" ({})", component.id)
    };
    terminal.result(format_args!(
        "{NAME}{}{NAME:#}{id}: {} in process {} of {}",
        component.name,
        component.state,
        remote_component.process(),
        remote_component.robot()
    ));
    terminal.result(format_args!(
        "  cycles      {}, {:.1} per second, {} periods missed, {} longer than the deadline",
        component.cycles, component.rate_hz, component.overruns, component.late
    ));
    let period = match component.period_ms {
        0 => String::new(),
        period => format!(", of {period} ms"),
    };
    terminal.result(format_args!(
        "  cycle time  {:.2} ms on average, {:.2} ms at most{period}",
        component.cycle_mean_ms, component.cycle_max_ms
    ));
    if let Some(thread) = thread(component) {
        terminal.result(format_args!("  thread      {thread}"));
    }
    if component.dropped + component.misfits > 0 {
        terminal.result(format_args!(
            "  lost        {} messages or requests dropped, {} unsuitable",
            component.dropped, component.misfits
        ));
    }
    let types = DeclaredTypes::of(remote_component, component);
    let mut typed = |what: &str, all: &[PresentEndpoint]| {
        for port in all {
            let (name, kind) = (&port.name, types.port(port));
            let lost = match port.lost {
                0 => String::new(),
                count => format!(", {count} messages lost"),
            };
            terminal.result(format_args!("  {what:<10}  {name}: {kind}{lost}"));
        }
    };
    typed("input", &component.inputs);
    typed("output", &component.outputs);
    typed("reference", &component.references);
    for service in &component.services {
        if service.refused > 0 {
            terminal.result(format_args!(
                "  service     {}.{}: {} requests refused because its queue was full",
                component.name, service.name, service.refused
            ));
        }
        for operation in &service.operations {
            let also = if operation.while_stopped {
                " (also while stopped)"
            } else {
                ""
            };
            terminal.result(format_args!(
                "  operation   {}.{}.{}{}{also}",
                component.name,
                service.name,
                operation.name,
                types.operation(&service.name, operation)
            ));
        }
    }
    for (property, value) in &component.properties {
        terminal.result(format_args!("  property    {property} = {value}"));
    }
    for (name, text) in inspection::entries(&component.inspection) {
        terminal.result(format_args!("  {name:<10}  {text}"));
    }
}
