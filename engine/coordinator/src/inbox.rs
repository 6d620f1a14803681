//! From messages to inputs: the event frame.
//!
//! A step sees at most one event of a function that takes them `all`; further events wait, in order,
//! for the steps that follow. So no event hides another one (two in one frame would: a REACHED could
//! cover a BLOCKED).

use crate::binding::{Binding, Monitored, Receive};
use crate::convert::{literal_of, value_of};
use crate::coordinator::BindError;
use crate::frame::Frame;
use asm_lang::Specification;
use asm_lang::ir::{FunctionId, Program, Shape};
use asm_lang::value::Value;
use component::{Cycle, Flow, In, Losses, Time};
use datum::Datum;
use std::collections::VecDeque;
use std::time::Duration;

/// More events than this do not wait: the oldest is dropped and counted.
const MAX_WAITING: usize = 256;

/// The bound inputs of a specification.
pub(crate) struct Inbox {
    inputs: Vec<Input>,
    /// Events dropped because too many waited, and messages that did not fit the codomain.
    pub losses: Losses,
}

struct Input {
    function: FunctionId,
    shape: Shape,
    port: Option<In<Datum>>,
    receive: Receive,
    field: Option<String>,
    none: Value,
    stale: Option<(Duration, Value)>,
    newest: Option<Time>,
    last: Option<Value>,
    /// Events, each with the out function whose call it answers, if it does.
    waiting: VecDeque<(Option<FunctionId>, Value)>,
}

impl Inbox {
    pub fn new(
        binding: &Binding,
        specification: &Specification,
        ports: &[(String, In<Datum>)],
    ) -> Result<Self, BindError> {
        let mut inputs = Vec::new();
        for monitored in &binding.monitored {
            inputs.push(Input::new(monitored, specification, ports)?);
        }
        Ok(Self {
            inputs,
            losses: Losses::default(),
        })
    }

    /// The input of an event function that calls report to; made if no port is bound to it.
    pub fn event(&mut self, name: &str, specification: &Specification) -> Result<usize, BindError> {
        let function = function(name, specification)?;
        if let Some(index) = self
            .inputs
            .iter()
            .position(|input| input.function == function)
        {
            return Ok(index);
        }
        self.inputs.push(Input {
            function,
            shape: codomain(function, &specification.program),
            port: None,
            receive: Receive::All,
            field: None,
            none: Value::Undef,
            stale: None,
            newest: None,
            last: None,
            waiting: VecDeque::new(),
        });
        Ok(self.inputs.len() - 1)
    }

    /// A literal of an event function.
    pub fn literal(&self, input: usize, name: &str, program: &Program) -> Option<Value> {
        match self.inputs.get(input)?.shape {
            Shape::Domain(domain) => literal_of(name, domain, program),
            _ => None,
        }
    }

    /// Adds the outcome of a call that an update of the out function made.
    pub fn push(&mut self, input: usize, value: Value, answers: FunctionId) {
        if let Some(input) = self.inputs.get_mut(input) {
            self.losses.dropped += input.wait(Some(answers), value);
        }
    }

    /// Takes back the outcomes that still wait and answer calls of this out function.
    pub fn withdraw(&mut self, answers: FunctionId) {
        for input in &mut self.inputs {
            input.waiting.retain(|(to, _)| *to != Some(answers));
        }
    }

    /// Whether an event waits for a following step.
    pub fn has_more(&self) -> bool {
        self.inputs.iter().any(|input| !input.waiting.is_empty())
    }

    /// Takes in the messages of the cycle.
    pub fn receive(&mut self, cycle: &Cycle<'_>, program: &Program) {
        for input in &mut self.inputs {
            let Some(port) = input.port else { continue };
            match input.receive {
                Receive::Edge => {
                    if !cycle.all(port).is_empty() || matches!(cycle.read(port), Flow::NewData(_)) {
                        input.last = Some(Value::Bool(true));
                    }
                }
                Receive::Last => {
                    if let Flow::NewData(message) = cycle.read(port) {
                        match input.value(message, program) {
                            Some(value) => {
                                input.newest = Some(cycle.now());
                                input.last = Some(value);
                            }
                            None => self.losses.misfits += 1,
                        }
                    }
                }
                Receive::All => {
                    for message in cycle.all(port) {
                        match input.value(message, program) {
                            Some(value) => self.losses.dropped += input.wait(None, value),
                            None => self.losses.misfits += 1,
                        }
                    }
                }
            }
        }
    }

    /// Fixes the inputs of the next step. An event that waits goes before the last message.
    pub fn freeze(&mut self, now: Time, frame: &mut Frame) {
        frame.clear();
        for input in &mut self.inputs {
            let event = input.waiting.pop_front().map(|(_, event)| event);
            let value = match input.receive {
                Receive::Edge => Value::Bool(input.last.take().is_some()),
                Receive::All => event.unwrap_or_else(|| input.none.clone()),
                Receive::Last => event.unwrap_or_else(|| input.latest(now)),
            };
            frame.set(input.function, value);
        }
    }
}

impl Input {
    fn new(
        monitored: &Monitored,
        specification: &Specification,
        ports: &[(String, In<Datum>)],
    ) -> Result<Self, BindError> {
        let program = &specification.program;
        let function = function(&monitored.function, specification)?;
        let shape = codomain(function, program);
        let port = ports
            .iter()
            .find(|(name, _)| *name == monitored.port)
            .map(|(_, port)| *port);
        let port = port.ok_or_else(|| BindError::UnknownPort {
            port: monitored.port.clone(),
        })?;
        let constant = |datum: &Option<Datum>| match datum {
            None => Ok(Value::Undef),
            Some(datum) => value_of(datum, &shape, program).ok_or_else(|| BindError::NotAValue {
                function: monitored.function.clone(),
                value: format!("{datum:?}"),
            }),
        };
        let none = constant(&monitored.none)?;
        let stale = match monitored.stale_ms {
            Some(age) => Some((Duration::from_millis(age), constant(&monitored.on_stale)?)),
            None => None,
        };
        Ok(Self {
            function,
            port: Some(port),
            receive: monitored.receive,
            field: monitored.field.clone(),
            none,
            stale,
            newest: None,
            last: None,
            waiting: VecDeque::new(),
            shape,
        })
    }

    fn value(&self, message: &Datum, program: &Program) -> Option<Value> {
        match &self.field {
            Some(field) => value_of(&*message.get(field)?, &self.shape, program),
            None => value_of(message, &self.shape, program),
        }
    }

    /// Adds an event; how many were dropped for it.
    fn wait(&mut self, answers: Option<FunctionId>, value: Value) -> u64 {
        self.waiting.push_back((answers, value));
        match self.waiting.len() > MAX_WAITING {
            true => {
                self.waiting.pop_front();
                1
            }
            false => 0,
        }
    }

    fn latest(&self, now: Time) -> Value {
        if let Some((age, value)) = &self.stale
            && self.newest.is_none_or(|newest| now.since(newest) > *age)
        {
            return value.clone();
        }
        self.last.clone().unwrap_or_else(|| self.none.clone())
    }
}

fn function(name: &str, specification: &Specification) -> Result<FunctionId, BindError> {
    specification
        .function(name, 0)
        .ok_or_else(|| BindError::UnknownFunction {
            function: name.to_owned(),
        })
}

fn codomain(function: FunctionId, program: &Program) -> Shape {
    program
        .functions
        .get(function.0 as usize)
        .map_or(Shape::Any, |function| function.codomain.clone())
}
