//! A protocol as an acceptor: follows all runs of the protocol that fit what was observed.

mod message_values;
mod possible;

use super::choices::ChoiceSequence;
use super::events::{EventSuccession, PrecedingEvent, SentEvent, after_step, successions};
use super::observed::{MessageEnd, ObservedCycle, ProtocolDeviation};
use crate::actor::{ActorInput, ActorOutput, Echo, InputOrigin, OutputEffect, read};
use crate::error::ModelError;
use crate::protocol::{ComponentNames, ends};
use asmotion_coordinator::Receive;
use asmotion_datum::Datum;
use asmotion_diagnostics::{Loader, Sources};
use asmotion_lang::ir::FunctionId;
use asmotion_lang::{Environment, Machine, Specification, Value};
use std::collections::{BTreeMap, BTreeSet};

/// Decides whether a protocol allows what a component does.
///
/// A cycle of the component is a step of the protocol. A component that sends several messages at once through one port makes
/// further steps, without new inputs, for all but the first. The acceptor keeps the states of all runs of the protocol that fit
/// what was observed so far; a cycle after which there is none left is a deviation.
pub struct ProtocolAcceptor {
    specification: Specification,
    machine: Machine,
    inputs: Vec<FollowedInput>,
    outputs: Vec<FollowedOutput>,
    echoes: Vec<Echo>,
    initial: Vec<u8>,
    states: BTreeSet<Vec<u8>>,
    /// The last messages: those of the last step that received or sent any.
    last: BTreeSet<PrecedingEvent>,
    /// Which events were observed to follow which.
    followed: BTreeSet<EventSuccession>,
    /// Newest content received at each end.
    newest: BTreeMap<MessageEnd, Datum>,
    cycle: u64,
}

struct FollowedInput {
    function: FunctionId,
    input: ActorInput,
    end: MessageEnd,
    /// `true` if the field is known only in the step after the arrival, because another function tells that.
    is_of_arrival: bool,
}

struct FollowedOutput {
    function: FunctionId,
    output: ActorOutput,
    end: MessageEnd,
    field: Option<String>,
}

/// A value that a message has for an out function.
#[derive(Clone, Debug, PartialEq)]
enum ExpectedValue {
    Value(Value),
    /// The message has no value, it has only arrived.
    Any,
}

/// The values of inputs in a step.
struct StepInputs<'a>(&'a BTreeMap<FunctionId, Value>);

impl Environment for StepInputs<'_> {
    fn read(&mut self, function: FunctionId, _: &[Value]) -> Result<Option<Value>, String> {
        Ok(Some(self.0.get(&function).cloned().unwrap_or_default()))
    }
}

impl ProtocolAcceptor {
    /// Reads the protocol of a component.
    ///
    /// # Errors
    /// The protocol has errors, or names something that the component does not have.
    pub fn open(
        component: &str,
        names: &ComponentNames,
        path: &str,
        loader: &dyn Loader,
    ) -> Result<Self, ModelError> {
        let mut sources = Sources::new();
        let files = read(path, loader, &mut sources, None)?;
        let found = ends(component, names, &files)?;
        let (specification, mut machine) = opened(path, loader)?;
        machine.keep_candidates();
        let function = |name: &str| specification.function(name, 0);
        let inputs = found.inputs.iter().filter_map(|input| {
            let same = |it: &&ActorInput| it.origin == input.origin && it.receive == Receive::Edge;
            Some(FollowedInput {
                function: function(&input.location)?,
                end: input_end(&input.origin)?,
                is_of_arrival: input.receive == Receive::Last
                    && found.inputs.iter().any(|it| same(&it)),
                input: input.clone(),
            })
        });
        let inputs: Vec<FollowedInput> = inputs.collect();
        let outputs = found.outputs.into_iter().filter_map(|output| {
            let (end, field) = output_end(&output.effect)?;
            Some(FollowedOutput {
                function: function(&output.location)?,
                output,
                end,
                field,
            })
        });
        let outputs: Vec<FollowedOutput> = outputs.collect();
        let mut initial = Vec::new();
        machine.pack_state(&mut initial);
        Ok(Self {
            states: BTreeSet::from([initial.clone()]),
            initial,
            machine,
            inputs,
            outputs,
            echoes: found.echoes,
            specification,
            last: BTreeSet::new(),
            followed: BTreeSet::new(),
            newest: BTreeMap::new(),
            cycle: 0,
        })
    }

    /// Returns to the initial state, as a component does when it is started again.
    pub fn restart(&mut self) {
        self.states = BTreeSet::from([self.initial.clone()]);
        self.newest.clear();
        self.last.clear();
    }

    /// Returns which events were observed to follow which, so far.
    pub fn followed(&self) -> &BTreeSet<EventSuccession> {
        &self.followed
    }

    /// Number of states in which the protocol can be.
    pub fn states(&self) -> usize {
        self.states.len()
    }

    /// The last messages before the events of a step with these inputs.
    fn with_arrivals(
        &self,
        last: &BTreeSet<PrecedingEvent>,
        inputs: &BTreeMap<FunctionId, Value>,
    ) -> BTreeSet<PrecedingEvent> {
        let arrived = self.inputs.iter().filter(|it| {
            it.input.receive == Receive::Edge
                && inputs.get(&it.function) == Some(&Value::Bool(true))
        });
        let arrived = arrived.map(|it| PrecedingEvent::Received(it.input.location.clone()));
        let arrived: BTreeSet<PrecedingEvent> = arrived.collect();
        if arrived.is_empty() {
            last.clone()
        } else {
            arrived
        }
    }

    /// Follows a cycle of the component, and returns the events that it sent.
    ///
    /// # Errors
    /// The protocol does not allow the cycle. The acceptor stays in the states before it.
    pub fn follow(
        &mut self,
        observed: &ObservedCycle,
    ) -> Result<BTreeSet<SentEvent>, ProtocolDeviation> {
        self.cycle += 1;
        for message in &observed.received {
            self.newest
                .insert(message.end.clone(), message.content.clone());
        }
        self.check_echoes(&observed.sent)?;
        let expected = self.expected(&observed.sent)?;
        let inputs = self.input_values(&observed.received)?;
        let quiet = self.input_values(&[])?;
        let steps = expected.values().map(Vec::len).max().unwrap_or(0).max(1);
        let mut states = self.states.clone();
        for step in 0..steps {
            let inputs = if step == 0 { &inputs } else { &quiet };
            let due = expected
                .iter()
                .filter_map(|(function, values)| Some((*function, values.get(step)?.clone())));
            let due: BTreeMap<FunctionId, ExpectedValue> = due.collect();
            states = self.successors(&states, inputs, &due)?;
        }
        self.states = states;
        self.last = self.with_arrivals(&self.last, &inputs);
        for step in 0..steps {
            let due = expected.iter().filter_map(|(function, values)| {
                Some((*function, vec![values.get(step)?.clone()]))
            });
            let sent = self.sent_events(&due.collect());
            self.followed.extend(successions(&self.last, &sent));
            self.last = after_step(&self.last, sent);
        }
        Ok(self.sent_events(&expected))
    }

    /// The states after a step with these inputs that sends exactly what is due.
    fn successors(
        &mut self,
        states: &BTreeSet<Vec<u8>>,
        inputs: &BTreeMap<FunctionId, Value>,
        due: &BTreeMap<FunctionId, ExpectedValue>,
    ) -> Result<BTreeSet<Vec<u8>>, ProtocolDeviation> {
        let mut next = BTreeSet::new();
        let mut allowed: BTreeSet<Vec<String>> = BTreeSet::new();
        let mut failure = None;
        for state in states {
            let mut choices = ChoiceSequence::default();
            loop {
                self.enter(state);
                let stepped = self.machine.step(&mut StepInputs(inputs), &mut choices, 0);
                if let Err(fault) = stepped {
                    failure.get_or_insert_with(|| self.specification.explain(&fault).message);
                } else {
                    let sent = self.sent();
                    if fits(&sent, due) {
                        self.forget_sent();
                        let mut packed = Vec::new();
                        self.machine.pack_state(&mut packed);
                        next.insert(packed);
                    } else {
                        allowed.insert(self.described(sent.into_iter()));
                    }
                }
                if !choices.advance() {
                    break;
                }
            }
        }
        if !next.is_empty() {
            return Ok(next);
        }
        let received = self.described(
            inputs
                .iter()
                .filter(|(_, value)| **value != Value::Undef && **value != Value::Bool(false))
                .map(|(function, value)| (*function, value.clone())),
        );
        if let (true, Some(reason)) = (allowed.is_empty(), failure) {
            return Err(ProtocolDeviation::ProtocolFails {
                cycle: self.cycle,
                received,
                reason,
            });
        }
        let sent = due.iter().map(|(function, value)| match value {
            ExpectedValue::Value(value) => (*function, value.clone()),
            ExpectedValue::Any => (*function, Value::Bool(true)),
        });
        Err(ProtocolDeviation::NotAllowed {
            cycle: self.cycle,
            received,
            sent: self.described(sent),
            allowed: allowed.into_iter().collect(),
        })
    }

    fn enter(&mut self, state: &[u8]) {
        // cannot fail: the bytes are from this machine
        let _ = self.machine.restore_state(state);
        self.forget_sent();
    }

    /// Makes all out functions undef, so that every update shows.
    fn forget_sent(&mut self) {
        for output in &self.outputs {
            let program = self.machine.program();
            let slot = self.machine.state().slot(program, output.function, &[]);
            if let Some(slot) = slot
                && let Some(value) = self.machine.slots_mut().get_mut(slot as usize)
            {
                *value = Value::Undef;
            }
        }
    }

    /// The out functions that the last step has updated, with their values.
    fn sent(&self) -> BTreeMap<FunctionId, Value> {
        let values = self.outputs.iter().map(|it| {
            let value = self.machine.value_at(it.function, &[]);
            (it.function, value)
        });
        values.filter(|(_, value)| *value != Value::Undef).collect()
    }

    fn described(&self, values: impl Iterator<Item = (FunctionId, Value)>) -> Vec<String> {
        let naming = self.machine.naming();
        let symbols = &self.specification.model;
        let name = |function: FunctionId| {
            let mut own = symbols.own_functions();
            let found = own.find(|(id, _)| id.0 == function.0);
            found.map_or_else(String::new, |(_, it)| it.name.to_string())
        };
        let described =
            values.map(|(function, value)| format!("{} = {}", name(function), value.show(&naming)));
        described.collect()
    }

    fn sent_events(
        &self,
        expected: &BTreeMap<FunctionId, Vec<ExpectedValue>>,
    ) -> BTreeSet<SentEvent> {
        let naming = self.machine.naming();
        let mut events = BTreeSet::new();
        for output in &self.outputs {
            for value in expected.get(&output.function).into_iter().flatten() {
                events.insert(SentEvent {
                    function: output.output.location.clone(),
                    value: match value {
                        ExpectedValue::Value(value) => value.show(&naming).to_string(),
                        ExpectedValue::Any => String::new(),
                    },
                });
            }
        }
        events
    }
}

/// Opens a specification as a machine in its initial state.
fn opened(path: &str, loader: &dyn Loader) -> Result<(Specification, Machine), ModelError> {
    let specification = asmotion_lang::open(path, loader);
    let specification = specification.map_err(|failure| ModelError::Specification {
        sources: Box::new(failure.sources),
        report: failure.report,
    })?;
    match specification.machine() {
        Ok(machine) => Ok((specification, machine)),
        Err(fault) => {
            let mut report = asmotion_diagnostics::Report::new();
            report.push(specification.explain(&fault));
            Err(ModelError::Specification {
                sources: Box::new(specification.sources),
                report,
            })
        }
    }
}

/// Returns `true` if a step has sent exactly what is due.
fn fits(sent: &BTreeMap<FunctionId, Value>, due: &BTreeMap<FunctionId, ExpectedValue>) -> bool {
    sent.len() == due.len()
        && due.iter().all(|(function, expected)| {
            sent.get(function).is_some_and(|value| match expected {
                ExpectedValue::Value(due) => value == due,
                ExpectedValue::Any => true,
            })
        })
}

fn input_end(origin: &InputOrigin) -> Option<MessageEnd> {
    match origin {
        InputOrigin::Port(port) => Some(MessageEnd::Port(port.clone())),
        InputOrigin::Request { service, operation } => Some(MessageEnd::Operation {
            service: service.clone(),
            operation: operation.clone(),
        }),
        InputOrigin::Calls
        | InputOrigin::Timer(_)
        | InputOrigin::Losses
        | InputOrigin::Value(_) => None,
    }
}

fn output_end(effect: &OutputEffect) -> Option<(MessageEnd, Option<String>)> {
    let operation = |service: &str, operation: &str| MessageEnd::Operation {
        service: service.to_owned(),
        operation: operation.to_owned(),
    };
    match effect {
        OutputEffect::Publish { port, field, .. } => {
            Some((MessageEnd::Port(port.clone()), field.clone()))
        }
        OutputEffect::Send {
            reference,
            operation: name,
            field,
        } => Some((operation(reference, name), field.clone())),
        OutputEffect::Reply {
            service,
            operation: name,
        } => Some((operation(service, name), None)),
        OutputEffect::Cases(_) => None,
    }
}
