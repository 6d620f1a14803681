//! Turns messages into inputs: the event frame.
//!
//! A step sees at most one event of a function with `receive = "all"`; further events wait in order for the following
//! steps. Otherwise one event could hide another in the same frame, for example a REACHED a BLOCKED.

use crate::bind_error::BindError;
use crate::binding::{Binding, Constant, Monitored, Receive, Source};
use crate::convert::{literal_value, value_of};
use crate::frame::InputFrame;
use crate::requests::Requests;
use asmotion_component::{Cycle, In, Losses, Time};
use asmotion_datum::Datum;
use asmotion_lang::Specification;
use asmotion_lang::ir::{FunctionId, Program, ValueShape};
use asmotion_lang::value::Value;
use std::borrow::Cow;
use std::collections::VecDeque;
use std::time::Duration;

/// Capacity of an event queue; when full, the oldest event is dropped and counted.
const MAX_WAITING: usize = 256;

/// The bound inputs of a specification.
pub(crate) struct MessageInputs {
    pub inputs: Vec<BoundInput>,
    /// Number of events dropped because a queue was full, and of messages that did not fit the codomain.
    pub losses: Losses,
}

pub(crate) struct BoundInput {
    function: FunctionId,
    shape: ValueShape,
    from: MessageOrigin,
    receive: Receive,
    field: Option<String>,
    is: Vec<String>,
    none: Value,
    stale: Option<(Duration, Value)>,
    pub newest: Option<Time>,
    pub last: Option<Value>,
    /// Waiting events, each with the out function whose call it reports on, if any.
    pub waiting: VecDeque<(Option<FunctionId>, Value)>,
}

/// Origin of an input's messages.
#[derive(Clone, Copy)]
enum MessageOrigin {
    /// Outcomes of calls only.
    Calls,
    Port(In<Datum>),
    /// Requests for the operation at this position.
    Requests(usize),
}

impl MessageInputs {
    pub fn new(
        binding: &Binding,
        specification: &Specification,
        ports: &[(String, In<Datum>)],
        requests: &Requests,
    ) -> Result<Self, BindError> {
        let mut inputs = Vec::new();
        for monitored in &binding.monitored {
            let from = origin(&monitored.from, ports, requests)?;
            inputs.push(BoundInput::new(monitored, from, specification)?);
        }
        Ok(Self {
            inputs,
            losses: Losses::default(),
        })
    }

    /// Position of the input of an event function that calls report to; creates one if no port is bound to it.
    pub fn event(&mut self, name: &str, specification: &Specification) -> Result<usize, BindError> {
        let function = function(name, specification)?;
        if let Some(index) = self
            .inputs
            .iter()
            .position(|input| input.function == function)
        {
            return Ok(index);
        }
        let shape = codomain(function, &specification.program);
        self.inputs.push(BoundInput {
            function,
            from: MessageOrigin::Calls,
            receive: Receive::All,
            field: None,
            is: Vec::new(),
            // a Boolean event is false in steps without the event
            none: if shape == ValueShape::Bool {
                Value::Bool(false)
            } else {
                Value::Undef
            },
            shape,
            stale: None,
            newest: None,
            last: None,
            waiting: VecDeque::new(),
        });
        Ok(self.inputs.len() - 1)
    }

    /// The value of a literal of an event function.
    pub fn literal(&self, input: usize, name: &str, program: &Program) -> Option<Value> {
        let shape = &self.inputs.get(input)?.shape;
        if *shape == ValueShape::Bool {
            return name.parse().ok().map(Value::Bool);
        }
        let ValueShape::Domain(domain) = shape else {
            return None;
        };
        literal_value(name, *domain, program)
    }

    /// Queues the outcome of a call that an update of `answers` made.
    pub fn push(&mut self, input: usize, value: Value, answers: FunctionId) {
        if let Some(input) = self.inputs.get_mut(input) {
            self.losses.dropped += input.enqueue(Some(answers), value);
        }
    }

    /// Removes waiting outcomes of calls that updates of this out function made.
    pub fn remove_outcomes(&mut self, answers: FunctionId) {
        for input in &mut self.inputs {
            input.waiting.retain(|(to, _)| *to != Some(answers));
        }
    }

    /// Returns whether an event waits for a following step.
    pub fn has_waiting_events(&self) -> bool {
        self.inputs.iter().any(|input| !input.waiting.is_empty())
    }

    /// Handles the messages of the cycle.
    pub fn receive(&mut self, cycle: &Cycle<'_>, requests: &Requests, program: &Program) {
        for input in &mut self.inputs {
            let (messages, newest) = match input.from {
                MessageOrigin::Calls => continue,
                MessageOrigin::Port(port) => (cycle.all(port), cycle.read(port).new()),
                MessageOrigin::Requests(position) => {
                    let received = requests.received(position);
                    (received, received.last())
                }
            };
            match input.receive {
                Receive::Edge if input.is.is_empty() => {
                    if newest.is_some() {
                        input.last = Some(Value::Bool(true));
                    }
                }
                Receive::Edge => {
                    let truth = Value::Bool(true);
                    if messages
                        .iter()
                        .any(|it| input.value(it, program).as_ref() == Some(&truth))
                    {
                        input.last = Some(truth);
                    }
                }
                Receive::Last => {
                    if let Some(message) = newest {
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
                    for message in messages {
                        match input.value(message, program) {
                            Some(value) => self.losses.dropped += input.enqueue(None, value),
                            None => self.losses.misfits += 1,
                        }
                    }
                }
            }
        }
    }

    /// Fixes the inputs of the next step. A waiting event takes precedence over the newest message.
    pub fn freeze(&mut self, now: Time, frame: &mut InputFrame) {
        frame.clear();
        for input in &mut self.inputs {
            let event = input.waiting.pop_front().map(|(_, event)| event);
            let value = match input.receive {
                Receive::Edge => Value::Bool(input.last.take().is_some()),
                Receive::All => event.unwrap_or_else(|| input.none.clone()),
                Receive::Last => event.unwrap_or_else(|| input.current_value(now)),
            };
            frame.set(input.function, value);
        }
    }
}

impl BoundInput {
    fn new(
        monitored: &Monitored,
        from: MessageOrigin,
        specification: &Specification,
    ) -> Result<Self, BindError> {
        let program = &specification.program;
        let function = function(&monitored.function, specification)?;
        let shape = codomain(function, program);
        let constant = |constant: &Option<Constant>| match constant {
            None => Ok(Value::Undef),
            Some(it) => value_of(&it.datum, &shape, program).ok_or_else(|| BindError::NotAValue {
                function: monitored.function.clone(),
                value: format!("{it:?}"),
            }),
        };
        let none = constant(&monitored.none)?;
        let stale = match monitored.stale_ms {
            Some(age) => Some((Duration::from_millis(age), constant(&monitored.on_stale)?)),
            None => None,
        };
        Ok(Self {
            function,
            from,
            receive: monitored.receive,
            field: monitored.field.clone().or_else(|| monitored.map.clone()),
            is: monitored.is.clone(),
            none,
            stale,
            newest: None,
            last: None,
            waiting: VecDeque::new(),
            shape,
        })
    }

    fn value(&self, message: &Datum, program: &Program) -> Option<Value> {
        let part = match &self.field {
            Some(field) => message.get(field)?,
            None => Cow::Borrowed(message),
        };
        if self.is.is_empty() {
            return value_of(&part, &self.shape, program);
        }
        let text = part.as_text()?;
        Some(Value::Bool(self.is.iter().any(|known| known == text)))
    }

    /// Queues an event. Returns how many events were dropped for it.
    fn enqueue(&mut self, answers: Option<FunctionId>, value: Value) -> u64 {
        self.waiting.push_back((answers, value));
        if self.waiting.len() > MAX_WAITING {
            self.waiting.pop_front();
            1
        } else {
            0
        }
    }

    fn current_value(&self, now: Time) -> Value {
        if let Some((age, value)) = &self.stale
            && self.newest.is_none_or(|newest| now.since(newest) > *age)
        {
            return value.clone();
        }
        self.last.clone().unwrap_or_else(|| self.none.clone())
    }
}

fn origin(
    source: &Source,
    ports: &[(String, In<Datum>)],
    requests: &Requests,
) -> Result<MessageOrigin, BindError> {
    match source {
        Source::Port(name) => {
            let port = ports.iter().find(|(known, _)| known == name);
            let (_, port) = port.ok_or_else(|| BindError::UnknownPort { port: name.clone() })?;
            Ok(MessageOrigin::Port(*port))
        }
        Source::Request(operation) => {
            let position = requests.position(operation);
            position
                .map(MessageOrigin::Requests)
                .ok_or_else(|| BindError::UnknownOperation(operation.clone()))
        }
    }
}

fn function(name: &str, specification: &Specification) -> Result<FunctionId, BindError> {
    specification
        .function(name, 0)
        .ok_or_else(|| BindError::UnknownFunction {
            function: name.to_owned(),
        })
}

fn codomain(function: FunctionId, program: &Program) -> ValueShape {
    program
        .functions
        .get(function.0 as usize)
        .map_or(ValueShape::Any, |function| function.codomain.clone())
}
