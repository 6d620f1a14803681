//! Orders: requests of others on the bus to the components of a process, as described in `docs/wire.md`.

use std::fmt;
use std::sync::Arc;

use asmotion_component::Transition;
use asmotion_component::declaration::{Declaration, PortDeclaration};
use asmotion_datum::{Datum, Schema};
use asmotion_runtime::{Asked, Run, RunError};
use serde::{Deserialize, Serialize};

use crate::last_samples::LastSamples;
use crate::message_check::check_message;
use crate::order_error::OrderError;
use crate::presence::PresentComponent;

/// The address at which a process takes orders, for example `control.onboard`.
pub fn control_address(process: &str) -> String {
    format!("control.{process}")
}

/// A request to a component.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Order {
    /// Name of the component.
    pub component: String,
    /// The requested action.
    pub wish: OrderKind,
}

/// The action that an order requests.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OrderKind {
    /// Makes the transition `configure`: reads the properties and prepares the component.
    Configure,
    /// Makes the transition `start`: begins cycling.
    Start,
    /// Makes the transition `stop`: ends cycling.
    Stop,
    /// Makes the transition `cleanup`: releases the component's resources.
    Cleanup,
    /// Makes the transition `recover`: leaves the error hook.
    Recover,
    /// Makes the transition `resetException`: leaves an exception.
    Reset,
    /// Sets properties from the next cycle on, all or none.
    Set(Vec<(String, Datum)>),
    /// Replies with the current description, a [`PresentComponent`].
    State,
    /// Replies with the [`Declaration`].
    Describe,
    /// Replies with the newest sample of an output.
    Read(String),
    /// Publishes an output for the duration of a lease, and replies with the topic.
    Watch(String),
    /// Injects a message into an input.
    Write(String, Datum),
}

/// The immediate outcome of an order.
pub enum OrderOutcome {
    /// The component carries it out after its current cycle.
    Pending(Asked),
    /// Carried out, with this reply.
    Done(Datum),
    /// The output `Component.port` of this type is to be published.
    Watched(String, Schema),
}

impl OrderKind {
    /// Returns whether the order only asks for something.
    pub fn is_question(&self) -> bool {
        match self {
            Self::State | Self::Describe | Self::Read(_) | Self::Watch(_) => true,
            Self::Configure
            | Self::Start
            | Self::Stop
            | Self::Cleanup
            | Self::Recover
            | Self::Reset
            | Self::Set(_)
            | Self::Write(..) => false,
        }
    }
}

/// The order in words, for example `set Follower.max_speed = 0.4`.
impl fmt::Display for Order {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let component = &self.component;
        match &self.wish {
            OrderKind::Configure => write!(f, "configure {component}"),
            OrderKind::Start => write!(f, "start {component}"),
            OrderKind::Stop => write!(f, "stop {component}"),
            OrderKind::Cleanup => write!(f, "cleanup {component}"),
            OrderKind::Recover => write!(f, "recover {component}"),
            OrderKind::Reset => write!(f, "reset {component}"),
            OrderKind::Set(values) => {
                f.write_str("set ")?;
                for (index, (name, value)) in values.iter().enumerate() {
                    let comma = if index == 0 { "" } else { ", " };
                    write!(f, "{comma}{component}.{name} = {value}")?;
                }
                Ok(())
            }
            OrderKind::Write(port, value) => write!(f, "write {component}.{port} {value}"),
            OrderKind::State | OrderKind::Describe | OrderKind::Read(_) | OrderKind::Watch(_) => {
                write!(f, "ask {component}")
            }
        }
    }
}

impl Order {
    /// Carries out the order, or has the component do so.
    ///
    /// # Errors
    /// An error if there is no such component or port, or if the port has the other direction, another type or no data.
    pub fn begin(
        &self,
        run: &mut dyn Run,
        newest: &LastSamples,
    ) -> Result<OrderOutcome, OrderError> {
        let mut go = |transition| {
            let asked = run.begin_transition(&self.component, transition)?;
            Ok(OrderOutcome::Pending(asked))
        };
        match &self.wish {
            OrderKind::Configure => go(Transition::Configure),
            OrderKind::Start => go(Transition::Start),
            OrderKind::Stop => go(Transition::Stop),
            OrderKind::Cleanup => go(Transition::Cleanup),
            OrderKind::Recover => go(Transition::Recover),
            OrderKind::Reset => go(Transition::ResetException),
            OrderKind::Set(values) => {
                let asked = run.begin_set_properties(&self.component, values)?;
                Ok(OrderOutcome::Pending(asked))
            }
            OrderKind::State => {
                self.declaration(run)?;
                let present = PresentComponent::of(&self.component, run);
                Ok(OrderOutcome::Done(Datum::of(&present)?))
            }
            OrderKind::Describe => Ok(OrderOutcome::Done(Datum::of(&self.declaration(run)?)?)),
            OrderKind::Read(port) => self.read(port, run, newest).map(OrderOutcome::Done),
            OrderKind::Watch(port) => {
                let output = self.output(port, run)?;
                Ok(OrderOutcome::Watched(self.full_name(port), output.schema))
            }
            OrderKind::Write(port, value) => {
                self.write(port, value, run)?;
                Ok(OrderOutcome::Done(Datum::Null))
            }
        }
    }

    fn read(&self, port: &str, run: &dyn Run, newest: &LastSamples) -> Result<Datum, OrderError> {
        self.output(port, run)?;
        let port = self.full_name(port);
        let sample = newest.of(&port).ok_or(OrderError::NoData { port })?;
        Ok(sample.to_datum()?)
    }

    fn write(&self, port: &str, value: &Datum, run: &mut dyn Run) -> Result<(), OrderError> {
        let name = self.full_name(port);
        check_message(value, &name, &self.input(port, run)?.schema)?;
        let now = run.now();
        Ok(run.inject_sample(now, &self.full_name(port), Arc::new(value.clone()))?)
    }

    fn output(&self, port: &str, run: &dyn Run) -> Result<PortDeclaration, OrderError> {
        let declared = self.declaration(run)?;
        match (declared.output(port), declared.input(port)) {
            (Some(output), _) => Ok(output.clone()),
            (None, Some(_)) => Err(OrderError::Direction {
                port: self.full_name(port),
                actual: "input",
                opposite: "write to it; only its component reads it",
            }),
            (None, None) => Err(self.unknown_port(port, &declared.outputs)),
        }
    }

    fn input(&self, port: &str, run: &dyn Run) -> Result<PortDeclaration, OrderError> {
        let declared = self.declaration(run)?;
        match (declared.input(port), declared.output(port)) {
            (Some(input), _) => Ok(input.clone()),
            (None, Some(_)) => Err(OrderError::Direction {
                port: self.full_name(port),
                actual: "output",
                opposite: "read from it; only its component writes it",
            }),
            (None, None) => Err(self.unknown_port(port, &declared.inputs)),
        }
    }

    fn declaration(&self, run: &dyn Run) -> Result<Declaration, OrderError> {
        let unknown = || RunError::Unknown {
            kind: "component",
            name: self.component.clone(),
            nearest: None,
        };
        Ok(run.declaration(&self.component).ok_or_else(unknown)?)
    }

    fn full_name(&self, port: &str) -> String {
        format!("{}.{port}", self.component)
    }

    fn unknown_port(&self, port: &str, ports: &[PortDeclaration]) -> OrderError {
        let names: Vec<_> = ports
            .iter()
            .map(|port| format!("`{}`", port.name))
            .collect();
        OrderError::Port {
            component: self.component.clone(),
            port: port.to_owned(),
            available: if names.is_empty() {
                "none".to_owned()
            } else {
                names.join(", ")
            },
        }
    }
}
