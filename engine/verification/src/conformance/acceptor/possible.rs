//! The events that a protocol can send, whatever it receives.

use super::super::choices::ChoiceSequence;
use super::super::events::{PossibleEvents, SentEvent, after_step, successions};
use super::{ProtocolAcceptor, StepInputs};
use asmotion_coordinator::Receive;
use asmotion_lang::Value;
use asmotion_lang::ir::FunctionId;
use std::collections::{BTreeMap, BTreeSet};

/// Limit for the steps that look for the events of a protocol.
const MAX_STEPS: usize = 1 << 20;

impl ProtocolAcceptor {
    /// Returns the events that the protocol can send, whatever it receives; `None` if it has too many states to find out.
    pub fn possible_events(&mut self) -> Option<PossibleEvents> {
        let inputs = self.all_inputs();
        let mut possible = PossibleEvents::default();
        // states with the events before them
        let start = (self.initial.clone(), BTreeSet::new());
        let mut known = BTreeSet::from([start.clone()]);
        let mut next = vec![start];
        let mut steps: usize = 0;
        while let Some((state, last)) = next.pop() {
            for inputs in &inputs {
                let last = self.with_arrivals(&last, inputs);
                let mut choices = ChoiceSequence::default();
                loop {
                    steps += 1;
                    if steps > MAX_STEPS {
                        return None;
                    }
                    self.enter(&state);
                    let stepped = self.machine.step(&mut StepInputs(inputs), &mut choices, 0);
                    if stepped.is_ok() {
                        let sent: BTreeSet<SentEvent> =
                            self.events_of(self.sent()).into_iter().collect();
                        possible.successions.extend(successions(&last, &sent));
                        possible.events.extend(sent.iter().cloned());
                        self.forget_sent();
                        let mut packed = Vec::new();
                        self.machine.pack_state(&mut packed);
                        let last = after_step(&last, sent);
                        if known.insert((packed.clone(), last.clone())) {
                            next.push((packed, last));
                        }
                    }
                    if !choices.advance() {
                        break;
                    }
                }
            }
        }
        Some(possible)
    }

    /// All combinations of values of the inputs, undef included for those that need not have a value.
    fn all_inputs(&self) -> Vec<BTreeMap<FunctionId, Value>> {
        let mut all = vec![BTreeMap::new()];
        for followed in &self.inputs {
            let codomain = &followed.input.codomain;
            let mut values = match &codomain.elements {
                Some(elements) => {
                    let elements = elements.iter();
                    elements.filter_map(|it| self.atom(&it.name)).collect()
                }
                None => vec![Value::Bool(false), Value::Bool(true)],
            };
            if followed.input.receive != Receive::Edge {
                values.push(Value::Undef);
            }
            let combined = all.iter().flat_map(|before: &BTreeMap<_, _>| {
                values.iter().map(|value| {
                    let mut inputs = before.clone();
                    inputs.insert(followed.function, value.clone());
                    inputs
                })
            });
            all = combined.collect();
        }
        all
    }
    fn events_of(&self, sent: BTreeMap<FunctionId, Value>) -> Vec<SentEvent> {
        let naming = self.machine.naming();
        let events = self.outputs.iter().filter_map(|it| {
            Some(SentEvent {
                function: it.output.location.clone(),
                value: sent.get(&it.function)?.show(&naming).to_string(),
            })
        });
        events.collect()
    }
}
