//! Orders: what others on the bus may have done to the components of a process. `docs/wire.md` describes them.

use std::sync::Arc;

use asmotion_component::Transition;
use asmotion_component::declaration::{Declaration, PortDeclaration};
use asmotion_datum::{Datum, Schema};
use asmotion_runtime::{Asked, Run, RunError};
use serde::{Deserialize, Serialize};

use crate::last_samples::LastSamples;
use crate::order_error::OrderError;
use crate::presence::PresentComponent;

/// Where a process takes orders: `control.onboard`.
pub fn control_address(process: &str) -> String {
    format!("control.{process}")
}

/// What a component shall do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Order {
    /// Which.
    pub component: String,
    /// What.
    pub wish: OrderKind,
}

/// What is wanted of a component.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OrderKind {
    /// To read its properties, and to get ready.
    Configure,
    /// To cycle.
    Start,
    /// To cycle no more.
    Stop,
    /// To give everything back.
    Cleanup,
    /// To leave its error hook.
    Recover,
    /// To leave an exception.
    Reset,
    /// To have these properties from its next cycle on: all of them, or none.
    Set(Vec<(String, Datum)>),
    /// To say how it is: its [`PresentComponent`], as of now.
    Look,
    /// To say what it declares: its [`Declaration`].
    Describe,
    /// To say what left one of its outputs last.
    Read(String),
    /// To have what leaves one of its outputs published for a while, on the topic that is answered.
    Watch(String),
    /// To take a message at one of its inputs.
    Write(String, Datum),
}

/// What became of an order.
pub enum OrderOutcome {
    /// The component does it when its present cycle has ended.
    Asked(Asked),
    /// It is done, and this is the answer.
    Done(Datum),
    /// This output, `Component.port`, shall be published.
    Watched(String, Schema),
}

impl Order {
    /// Has it carried out.
    ///
    /// # Errors
    /// There is no such component or port, the port goes the other way, takes another type, or has no data.
    pub fn begin(
        &self,
        run: &mut dyn Run,
        newest: &LastSamples,
    ) -> Result<OrderOutcome, OrderError> {
        let mut go = |transition| {
            let asked = run.begin_transition(&self.component, transition)?;
            Ok(OrderOutcome::Asked(asked))
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
                Ok(OrderOutcome::Asked(asked))
            }
            OrderKind::Look => {
                self.declared(run)?;
                let present = PresentComponent::of(&self.component, run);
                Ok(OrderOutcome::Done(Datum::of(&present)?))
            }
            OrderKind::Describe => Ok(OrderOutcome::Done(Datum::of(&self.declared(run)?)?)),
            OrderKind::Read(port) => self.read(port, run, newest).map(OrderOutcome::Done),
            OrderKind::Watch(port) => {
                let output = self.output(port, run)?;
                Ok(OrderOutcome::Watched(self.whole(port), output.schema))
            }
            OrderKind::Write(port, value) => {
                self.write(port, value, run)?;
                Ok(OrderOutcome::Done(Datum::Null))
            }
        }
    }

    fn read(&self, port: &str, run: &dyn Run, newest: &LastSamples) -> Result<Datum, OrderError> {
        self.output(port, run)?;
        let port = self.whole(port);
        let sample = newest.of(&port).ok_or(OrderError::NoData { port })?;
        Ok(sample.to_datum()?)
    }

    fn write(&self, port: &str, value: &Datum, run: &mut dyn Run) -> Result<(), OrderError> {
        self.input(port, run)?;
        let now = run.now();
        Ok(run.inject_sample(now, &self.whole(port), Arc::new(value.clone()))?)
    }

    fn output(&self, port: &str, run: &dyn Run) -> Result<PortDeclaration, OrderError> {
        let declared = self.declared(run)?;
        match (declared.output(port), declared.input(port)) {
            (Some(output), _) => Ok(output.clone()),
            (None, Some(_)) => Err(OrderError::Direction {
                port: self.whole(port),
                is: "input",
                instead: "it is written, and read by its component alone",
            }),
            (None, None) => Err(self.no_port(port, &declared.outputs)),
        }
    }

    fn input(&self, port: &str, run: &dyn Run) -> Result<PortDeclaration, OrderError> {
        let declared = self.declared(run)?;
        match (declared.input(port), declared.output(port)) {
            (Some(input), _) => Ok(input.clone()),
            (None, Some(_)) => Err(OrderError::Direction {
                port: self.whole(port),
                is: "output",
                instead: "it is read, and written by its component alone",
            }),
            (None, None) => Err(self.no_port(port, &declared.inputs)),
        }
    }

    fn declared(&self, run: &dyn Run) -> Result<Declaration, OrderError> {
        let unknown = || RunError::Unknown {
            what: "component",
            name: self.component.clone(),
            nearest: None,
        };
        Ok(run.declaration(&self.component).ok_or_else(unknown)?)
    }

    fn whole(&self, port: &str) -> String {
        format!("{}.{port}", self.component)
    }

    fn no_port(&self, port: &str, ports: &[PortDeclaration]) -> OrderError {
        let names: Vec<_> = ports
            .iter()
            .map(|port| format!("`{}`", port.name))
            .collect();
        OrderError::Port {
            component: self.component.clone(),
            port: port.to_owned(),
            known: match names.is_empty() {
                true => "none of this direction".to_owned(),
                false => names.join(", "),
            },
        }
    }
}
