//! Turns messages into inputs: the event frame.
//!
//! A step sees at most one event of a location with `receive = "all"`; further events wait in order for the following
//! steps. Otherwise one event could hide another in the same frame, for example a REACHED a BLOCKED.

mod arrived;
mod bound;

use self::arrived::ArrivedMessages;
pub(crate) use self::bound::{BoundInput, InputLocation};
use self::bound::{LostMessages, MessageCondition, MessageOrigin, origin};
use crate::bind_error::BindError;
use crate::binding::{Binding, Receive};
use crate::bound_location::BoundLocations;
use crate::content::{AfterStep, EffectContext, evaluate};
use crate::convert::literal_value;
use crate::event_queue::{Arrival, EventQueue};
use crate::frame::InputFrame;
use crate::location::LocationName;
use crate::misfit::MisfitCauses;
use crate::requests::Requests;
use crate::terms::BindingTerms;
use crate::typed_input::TypedInput;
use asmotion_component::{BufferKind, Cycle, Flow, Losses, Time, prefetch};
use asmotion_lang::Specification;
use asmotion_lang::ir::{FunctionId, Program, ValueShape};
use asmotion_lang::machine::{Machine, StepFault};
use asmotion_lang::value::Value;

/// The bound inputs of a specification.
pub(crate) struct MessageInputs {
    pub inputs: Vec<BoundInput>,
    /// Input and location of each position in the frame.
    owners: Vec<EventTarget>,
    /// Number of events dropped because a queue was full, and of messages that did not fit the codomain, the key or the
    /// expected values.
    pub losses: Losses,
    /// Number of dropped events that did not arrive at a port: outcomes of calls, and requests.
    pub dropped_elsewhere: u64,
}

/// A location that takes events: the position of its input, and its position there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct EventTarget {
    input: usize,
    location: usize,
}

impl MessageInputs {
    /// Resolves the bindings of monitored functions, and adds their locations to the frame.
    pub fn new(
        binding: &Binding,
        specification: &Specification,
        ports: &[TypedInput],
        requests: &Requests,
        terms: &BindingTerms,
        frame: &mut InputFrame,
    ) -> Result<Self, BindError> {
        let mut inputs = Self {
            inputs: Vec::with_capacity(binding.monitored.len()),
            owners: Vec::new(),
            losses: Losses::default(),
            dropped_elsewhere: 0,
        };
        for monitored in &binding.monitored {
            let from = origin(&monitored.from, ports, requests, terms)?;
            let located =
                BoundLocations::resolve(&monitored.location, &monitored.key, specification)?;
            let mut input = BoundInput::new(monitored, located, from, &specification.program)?;
            input.matching = MessageCondition::new(&monitored.matching, terms)?;
            inputs.add(input, &monitored.location, frame)?;
        }
        Ok(inputs)
    }

    fn add(
        &mut self,
        mut input: BoundInput,
        name: &LocationName,
        frame: &mut InputFrame,
    ) -> Result<(), BindError> {
        let located = input.located.all();
        input.locations.reserve_exact(located.len());
        self.owners.reserve(located.len());
        for (location, bound) in located.into_iter().enumerate() {
            let position = frame.bind(input.located.function, bound.arguments.clone());
            let position = position.ok_or_else(|| BindError::BoundTwice {
                location: name.to_string(),
            })?;
            input.locations.push(InputLocation {
                arguments: bound.arguments,
                position,
                newest: None,
                has_received: false,
                last: None,
                waiting: EventQueue::default(),
            });
            self.owners.push(EventTarget {
                input: self.inputs.len(),
                location,
            });
        }
        // an input is large, and few follow
        self.inputs.reserve_exact(1);
        self.inputs.push(input);
        Ok(())
    }

    /// The location that calls report to; creates an input for it if it has no binding.
    pub fn event(
        &mut self,
        name: &LocationName,
        specification: &Specification,
        frame: &mut InputFrame,
    ) -> Result<EventTarget, BindError> {
        let located = BoundLocations::resolve(name, &[], specification)?;
        let arguments = located.all().into_iter().map(|location| location.arguments);
        let arguments = arguments.last().unwrap_or_default();
        let position = frame.position(located.function, &arguments);
        if let Some(target) = position.and_then(|position| self.owners.get(position)) {
            return Ok(*target);
        }
        let input = BoundInput {
            from: MessageOrigin::Calls,
            receive: Receive::All,
            field: None,
            is: Vec::new(),
            // a Boolean event is false in steps without the event
            none: if located.codomain == ValueShape::Bool {
                Value::Bool(false)
            } else {
                Value::Undef
            },
            located,
            stale: None,
            matching: None,
            lost: LostMessages::default(),
            locations: Vec::new(),
            reported_key: false,
            reported_expiry: false,
            causes: MisfitCauses::default(),
        };
        self.add(input, name, frame)?;
        Ok(EventTarget {
            input: self.inputs.len() - 1,
            location: 0,
        })
    }

    /// The value of a literal of an event function.
    pub fn literal(&self, target: EventTarget, name: &str, program: &Program) -> Option<Value> {
        let shape = &self.inputs.get(target.input)?.located.codomain;
        if *shape == ValueShape::Bool {
            return name.parse().ok().map(Value::Bool);
        }
        let ValueShape::Domain(domain) = shape else {
            return None;
        };
        literal_value(name, *domain, program)
    }

    /// Queues the outcome of a call that an update of the out location at position `answers` made.
    pub fn push(&mut self, target: EventTarget, value: Value, answers: usize) {
        let input = self.inputs.get_mut(target.input);
        if let Some(location) = input.and_then(|input| input.locations.get_mut(target.location)) {
            let dropped = location.waiting.push_outcome(answers, value);
            self.losses.dropped += dropped;
            self.dropped_elsewhere += dropped;
        }
    }

    /// Removes waiting outcomes of calls that updates of the out location at this position made.
    pub fn remove_outcomes(&mut self, answers: usize) {
        for location in self
            .inputs
            .iter_mut()
            .flat_map(|input| &mut input.locations)
        {
            location.waiting.remove_outcomes(answers);
        }
    }

    /// Returns the number of events that wait for a following step.
    pub fn waiting_events(&self) -> u64 {
        let locations = self.inputs.iter().flat_map(|input| &input.locations);
        locations
            .map(|location| location.waiting.len() as u64)
            .sum()
    }

    /// Returns the number of outcomes of calls that wait for a following step.
    pub fn waiting_outcomes(&self) -> usize {
        let locations = self.inputs.iter().flat_map(|input| &input.locations);
        locations.map(|location| location.waiting.outcomes()).sum()
    }

    /// Returns whether a function is bound to a timer.
    pub fn has_timer(&self, function: FunctionId) -> bool {
        let is_timer = |input: &BoundInput| matches!(input.from, MessageOrigin::Timer(..));
        let mut inputs = self.inputs.iter();
        inputs.any(|input| input.located.function == function && is_timer(input))
    }

    /// Determines the values that messages must have in this cycle. Waiting messages with other values are refused.
    pub fn update_conditions(
        &mut self,
        context: &EffectContext<'_>,
        state: &mut AfterStep<'_>,
        cycle: &Cycle<'_>,
    ) {
        for input in &mut self.inputs {
            let Some(condition) = &mut input.matching else {
                continue;
            };
            let expected = evaluate(&condition.content, context, state, cycle).ok();
            if condition.expected != expected {
                condition.expected = expected;
                let queues = input.locations.iter_mut().map(|it| &mut it.waiting);
                self.losses.misfits += queues.map(EventQueue::remove_messages).sum::<u64>();
            }
        }
    }

    /// Handles the messages of the cycle. Returns notices about messages that do not fit, about the first message of each input
    /// whose key selects no element, about the first one that is refused, about the first one that waited too long, and about
    /// messages that are gone with their connection.
    pub fn receive(
        &mut self,
        cycle: &mut Cycle<'_>,
        ports: &[TypedInput],
        requests: &Requests,
        program: &Program,
    ) -> Vec<String> {
        let mut notices = Vec::new();
        let mut mistyped = Vec::new();
        let mut discarded = Vec::new();
        for (position, input) in self.inputs.iter_mut().enumerate() {
            let (port, mut dropped) = (input.from.port(), Vec::new());
            if let Some(port) = port {
                dropped = input.discard_stale(port, cycle);
                notices.extend(input.expired(dropped.len(), program));
            }
            let (messages, newest) = match input.from {
                MessageOrigin::Calls | MessageOrigin::Timer(..) => continue,
                MessageOrigin::Losses(port) => {
                    input.lost.now = cycle.lost(port);
                    continue;
                }
                MessageOrigin::Port(port) => {
                    let read = cycle.read(port);
                    // stale messages disappear without a notice: the policy of the connection says so
                    if matches!(read, Flow::NoData) && input.forget() && !cycle.is_stale(port) {
                        notices.push(input.without_connection(program));
                    }
                    (cycle.all(port), read.new())
                }
                MessageOrigin::Requests(position) => {
                    let received = requests.received(position);
                    (received, received.last())
                }
            };
            let arrived = ArrivedMessages {
                messages,
                newest,
                expiries: port.map_or(&[][..], |port| cycle.expiries(port)),
                queue: port.map_or(BufferKind::Data, |port| cycle.queue(port)),
                typed: ports.iter().find(|it| Some(it.port) == port),
                now: cycle.now(),
            };
            let unused = input.take_all(&arrived, (requests, program), &mut mistyped, &mut notices);
            self.losses.misfits += unused.misfits;
            dropped.extend(unused.dropped);
            discarded.extend(dropped.into_iter().map(|arrival| (position, arrival)));
        }
        self.count_discarded(discarded, cycle);
        notices
    }

    /// Counts messages, each with the position of the input that has discarded it. One that several inputs have discarded counts
    /// once.
    fn count_discarded(&mut self, mut discarded: Vec<(usize, Arrival)>, cycle: &mut Cycle<'_>) {
        for (position, _) in &mut discarded {
            if let Some(from) = self.inputs.get(*position).map(|input| input.from) {
                let first = self
                    .inputs
                    .iter()
                    .position(|it| it.from.shares_messages(from));
                *position = first.unwrap_or(*position);
            }
        }
        discarded.sort_unstable();
        discarded.dedup();
        for of_one in discarded.chunk_by(|(one, _), (next, _)| one == next) {
            let count = of_one.len() as u64;
            let input = of_one
                .first()
                .and_then(|(position, _)| self.inputs.get(*position));
            self.losses.dropped += count;
            match input.and_then(|input| input.from.port()) {
                Some(port) => cycle.count_lost(port, count),
                None => self.dropped_elsewhere += count,
            }
        }
    }

    /// Sets the inputs to their current values and leaves the waiting events to the next step.
    pub fn observe(&self, now: Time, frame: &mut InputFrame) {
        for input in &self.inputs {
            for location in &input.locations {
                let value = match (input.from, input.receive) {
                    (MessageOrigin::Losses(_), _) => input.lost.value(&input.located.codomain),
                    (MessageOrigin::Timer(_, after), _) => location.has_elapsed(after, now),
                    (_, Receive::Edge) => Value::Bool(location.last.is_some()),
                    (_, Receive::All) => input.none.clone(),
                    (_, Receive::Last) => location.current_value(now, &input.stale, &input.none),
                };
                frame.set(location.position, value);
            }
        }
    }

    /// Fixes the inputs of the next step. A waiting event takes precedence over the newest message.
    pub fn freeze(&mut self, now: Time, frame: &mut InputFrame) {
        for input in &mut self.inputs {
            for location in &mut input.locations {
                let event = location.waiting.pop();
                let value = match (input.from, input.receive) {
                    (MessageOrigin::Losses(_), _) => input.lost.value(&input.located.codomain),
                    (MessageOrigin::Timer(_, after), _) => {
                        event.unwrap_or_else(|| location.has_elapsed(after, now))
                    }
                    (_, Receive::Edge) => Value::Bool(location.last.take().is_some()),
                    (_, Receive::All) => event.unwrap_or_else(|| input.none.clone()),
                    (_, Receive::Last) => event
                        .unwrap_or_else(|| location.current_value(now, &input.stale, &input.none)),
                };
                frame.set(location.position, value);
            }
            input.lost.before = input.lost.now;
        }
    }

    /// Prefetches the list of inputs.
    pub fn prefetch(&self) {
        prefetch(&*self.inputs);
    }

    /// Prefetches what the inputs point to.
    pub fn prefetch_each(&self) {
        for input in &self.inputs {
            prefetch(&*input.locations);
            prefetch(input.field.as_deref().unwrap_or_default());
        }
    }

    /// Stops all timers, because the machine begins again.
    pub fn stop_timers(&mut self) {
        let timers = self.inputs.iter_mut();
        let timers = timers.filter(|input| matches!(input.from, MessageOrigin::Timer(..)));
        for location in timers.flat_map(|input| &mut input.locations) {
            location.newest = None;
        }
    }

    /// Starts the timers whose conditions hold in the current state, and stops the others. A timer that runs already
    /// continues.
    ///
    /// # Errors
    /// The evaluation of a condition fails.
    pub fn update_timers(
        &mut self,
        machine: &mut Machine,
        frame: &mut InputFrame,
        now: Time,
    ) -> Result<(), Box<StepFault>> {
        for input in &mut self.inputs {
            let MessageOrigin::Timer(term, _) = input.from else {
                continue;
            };
            let holds = machine.evaluate(term, frame, now.nanos())? == Value::Bool(true);
            for location in &mut input.locations {
                location.newest = holds.then(|| location.newest.unwrap_or(now));
            }
        }
        Ok(())
    }
}
