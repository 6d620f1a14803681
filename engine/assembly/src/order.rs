//! Orders: what others on the bus may have done to the components of a process. `docs/wire.md` describes them.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use component::declaration::PortDeclaration;
use component::{Asked, Event, Observer, Run, RunError, Time, Transition};
use datum::{Datum, DatumError, Sample};
use serde::{Deserialize, Serialize};

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
    pub wish: Wish,
}

/// What is wanted of a component.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Wish {
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
    /// To say what it declares: its [`Declaration`](crate::declaration::Declaration).
    Describe,
    /// To say what left one of its outputs last.
    Read(String),
    /// To take a message at one of its inputs.
    Write(String, Datum),
}

/// What became of an order.
pub enum Begun {
    /// The component does it when its present cycle has ended.
    Asked(Asked),
    /// It is done, and this is the answer.
    Done(Datum),
}

/// Why an order is not carried out.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum OrderError {
    /// What the system refuses.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The component has no such port.
    #[error("`{component}` has no port `{port}`; it has {known}")]
    Port {
        /// The component.
        component: String,
        /// The port asked for.
        port: String,
        /// Those it has.
        known: String,
    },
    /// An input to be read, or an output to be written.
    #[error("`{port}` is an {is}: {instead}")]
    Direction {
        /// `Component.port`.
        port: String,
        /// What it is.
        is: &'static str,
        /// What can be done with it.
        instead: &'static str,
    },
    /// Nothing has left the port yet.
    #[error("nothing has left `{port}` yet")]
    NoData {
        /// `Component.port`.
        port: String,
    },
    /// What would be answered has no form.
    #[error(transparent)]
    Datum(#[from] DatumError),
}

impl OrderError {
    /// Its code, for programs.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Run(RunError::Mismatch { .. }) => "WRONG_TYPE",
            Self::Run(_) => "REFUSED",
            Self::Port { .. } => "NO_PORT",
            Self::Direction { .. } => "WRONG_DIRECTION",
            Self::NoData { .. } => "NO_DATA",
            Self::Datum(_) => "NO_FORM",
        }
    }
}

/// What left each output last.
#[derive(Clone, Default)]
pub struct Newest(Arc<Mutex<BTreeMap<String, Arc<dyn Sample>>>>);

impl Observer for Newest {
    fn observe(&mut self, _: Time, event: &Event<'_>) {
        if let Event::Published {
            component,
            port,
            sample,
            ..
        } = event
        {
            let mut samples = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            samples.insert(format!("{component}.{port}"), sample.to_shared());
        }
    }
}

impl Newest {
    fn of(&self, port: &str) -> Option<Arc<dyn Sample>> {
        let samples = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        samples.get(port).cloned()
    }
}

impl Order {
    /// Has it carried out.
    ///
    /// # Errors
    /// There is no such component or port, the port goes the other way, takes another type, or has no data.
    pub fn begin(&self, run: &mut dyn Run, newest: &Newest) -> Result<Begun, OrderError> {
        let mut go = |transition| {
            let asked = run.begin_transition(&self.component, transition)?;
            Ok(Begun::Asked(asked))
        };
        match &self.wish {
            Wish::Configure => go(Transition::Configure),
            Wish::Start => go(Transition::Start),
            Wish::Stop => go(Transition::Stop),
            Wish::Cleanup => go(Transition::Cleanup),
            Wish::Recover => go(Transition::Recover),
            Wish::Reset => go(Transition::ResetException),
            Wish::Set(values) => {
                let asked = run.begin_set_properties(&self.component, values)?;
                Ok(Begun::Asked(asked))
            }
            Wish::Describe => match run.declaration(&self.component) {
                Some(declaration) => Ok(Begun::Done(Datum::of(&declaration)?)),
                None => Err(self.unknown()),
            },
            Wish::Read(port) => self.read(port, run, newest).map(Begun::Done),
            Wish::Write(port, value) => {
                self.write(port, value, run)?;
                Ok(Begun::Done(Datum::Null))
            }
        }
    }

    fn read(&self, port: &str, run: &dyn Run, newest: &Newest) -> Result<Datum, OrderError> {
        let declared = run
            .declaration(&self.component)
            .ok_or_else(|| self.unknown())?;
        let name = format!("{}.{port}", self.component);
        if declared.output(port).is_none() {
            return Err(match declared.input(port) {
                Some(_) => OrderError::Direction {
                    port: name,
                    is: "input",
                    instead: "it is written, and read by its component alone",
                },
                None => self.no_port(port, &declared.outputs),
            });
        }
        let sample = newest.of(&name).ok_or(OrderError::NoData { port: name })?;
        Ok(sample.to_datum()?)
    }

    fn write(&self, port: &str, value: &Datum, run: &mut dyn Run) -> Result<(), OrderError> {
        let declared = run
            .declaration(&self.component)
            .ok_or_else(|| self.unknown())?;
        let name = format!("{}.{port}", self.component);
        if declared.input(port).is_none() {
            return Err(match declared.output(port) {
                Some(_) => OrderError::Direction {
                    port: name,
                    is: "output",
                    instead: "it is read, and written by its component alone",
                },
                None => self.no_port(port, &declared.inputs),
            });
        }
        let now = run.now();
        Ok(run.inject_sample(now, &name, Arc::new(value.clone()))?)
    }

    fn unknown(&self) -> OrderError {
        OrderError::Run(RunError::Unknown {
            what: "component",
            name: self.component.clone(),
            nearest: None,
        })
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
