//! Calls of services: the literals of an out function that make them, their states and their ends.

use super::EnvironmentWriter;
use crate::actor::{
    Actor, ActorInput, ActorOutput, InputOrigin, OutputEffect, qualified_word, word,
};
use crate::error::ModelError;
use crate::glue::sequence;
use crate::message::SentMessage;
use crate::network::providers;
use crate::rename::label;
use asmotion_coordinator::{Action, Call, Receive};
use asmotion_plan::End;
use std::collections::BTreeSet;

/// A call that a location of an out function makes.
pub(super) struct LocationCall<'a> {
    /// Literal of the call's state.
    pub state: String,
    pub call: &'a Call,
}

impl EnvironmentWriter<'_> {
    /// The literals with which a call can end; `None` for an end without an event.
    pub(super) fn outcomes(&self, actor: &Actor, call: &Call) -> BTreeSet<Option<String>> {
        let reference = End {
            component: actor.component.clone(),
            name: call.operation.service.clone(),
        };
        let providers = providers(self.plan, &reference);
        let mut ends = BTreeSet::new();
        let is_open = providers.outside || providers.ends.is_empty();
        let mut any_fault = is_open;
        let mut replies = is_open;
        for end in &providers.ends {
            let key = (
                end.component.clone(),
                end.name.clone(),
                call.operation.operation.clone(),
            );
            match self.answers.get(&key) {
                None => (any_fault, replies) = (true, true),
                Some(answers) => {
                    for answer in answers {
                        if answer == "OK" {
                            replies = true;
                            continue;
                        }
                        let named = call.faults.iter().find(|(code, _)| code == answer);
                        ends.insert(
                            named
                                .map(|(_, it)| it.clone())
                                .or_else(|| call.failed.clone()),
                        );
                    }
                }
            }
        }
        if any_fault {
            ends.extend(call.faults.iter().map(|(_, literal)| Some(literal.clone())));
            ends.insert(call.failed.clone());
        }
        if replies {
            ends.insert(call.ok.clone());
        }
        ends.insert(call.timeout.clone().or_else(|| call.failed.clone()));
        ends.insert(call.unavailable.clone().or_else(|| call.failed.clone()));
        ends
    }

    /// The effects of the literals of an out function.
    pub(super) fn cases(
        &mut self,
        at: usize,
        actor: &Actor,
        output: &ActorOutput,
        cases: &[(crate::actor::ElementName, Vec<Action>)],
    ) -> Result<Vec<String>, ModelError> {
        let calls = calls(actor, output);
        let mut rules = Vec::new();
        if !calls.is_empty() {
            let state = call_state(actor, output);
            let mut literals = vec![format!("NO_{}", state.to_uppercase())];
            literals.extend(calls.iter().map(|it| it.state.clone()));
            self.glue.declare(
                &format!(
                    "the call that `{}` of {} makes",
                    output.location, actor.component
                ),
                format!("enum domain Calls_{state} = {{{}}}", literals.join(" | ")),
            );
            self.glue
                .declare("", format!("controlled {state}: Calls_{state}"));
            self.glue
                .start(&state, &format!("NO_{}", state.to_uppercase()));
            if at == 0 {
                if has_queue(actor, output) {
                    self.glue.declare(
                        "messages that were waiting when the call was made: its outcome comes after them",
                        format!("controlled ahead_{state}: Integer"),
                    );
                    self.glue.start(&format!("ahead_{state}"), "0");
                }
                self.glue
                    .declare("", format!("controlled renewed_{state}: Boolean"));
                self.glue.start(&format!("renewed_{state}"), "false");
                self.glue.justice(
                    "a call ends, by an answer or by its timeout, unless another one takes its place",
                    &format!("{state} = NO_{} or renewed_{state}", state.to_uppercase()),
                );
            }
        }
        let mut branches = Vec::new();
        for (literal, actions) in cases {
            let mut effects = Vec::new();
            // an update to a value with an action cancels the call
            let is_call = |action: &Action| matches!(action, Action::Call(_));
            if !calls.is_empty() && !actions.is_empty() && !actions.iter().any(is_call) {
                let state = call_state(actor, output);
                effects.push(format!("{state} := NO_{}", state.to_uppercase()));
            }
            for action in actions {
                match action {
                    Action::Cancel(_) => {}
                    Action::Call(call) => {
                        let made = calls.iter().find(|it| std::ptr::eq(it.call, call));
                        if let Some(made) = made {
                            let state = call_state(actor, output);
                            effects.push(format!("{state} := {}", made.state));
                            if at == 0 {
                                effects.push(format!("renewed_{state} := true"));
                                if let Some(queue) = queue_of(actor, call) {
                                    effects.push(format!("ahead_{state} := length({queue})"));
                                }
                            }
                        }
                        let message = SentMessage::Built(&call.with);
                        let operation = &call.operation;
                        effects.extend(self.request(
                            at,
                            &operation.service,
                            &operation.operation,
                            &message,
                        )?);
                    }
                    Action::Publish { port, value } => {
                        effects.extend(self.publish(at, port, &SentMessage::Built(value))?);
                    }
                }
            }
            if !effects.is_empty() {
                branches.push(format!("case {}: {}", literal.name, sequence(&effects)));
            }
        }
        if !branches.is_empty() {
            let x = &output.location;
            rules.push(format!("switch {x} {} endswitch", branches.join("\n")));
        }
        Ok(rules)
    }

    /// A rule for calls that can end without an event.
    pub(super) fn silent_ends(&self, actor: &Actor, output: &ActorOutput) -> Option<String> {
        let calls = calls(actor, output);
        let silent = calls
            .iter()
            .filter(|it| it.call.event.is_none() || self.outcomes(actor, it.call).contains(&None));
        let state = call_state(actor, output);
        let silent: Vec<String> = silent.map(|it| format!("{state} = {}", it.state)).collect();
        if silent.is_empty() {
            return None;
        }
        Some(format!(
            "if {} then choose $ends in Boolean do if $ends then {state} := NO_{} endif endif",
            silent.join(" or "),
            state.to_uppercase()
        ))
    }
}

/// The function that tells which call an out location has made.
pub(super) fn call_state(actor: &Actor, output: &ActorOutput) -> String {
    format!("call_{}", qualified_word(actor, &output.word))
}

/// The calls that the literals of an out location make.
pub(super) fn calls<'a>(actor: &Actor, output: &'a ActorOutput) -> Vec<LocationCall<'a>> {
    let OutputEffect::Cases(cases) = &output.effect else {
        return Vec::new();
    };
    let state = call_state(actor, output).to_uppercase();
    let calls = cases.iter().flat_map(|(literal, actions)| {
        let calls = actions.iter().filter_map(|action| match action {
            Action::Call(call) => Some(call),
            Action::Publish { .. } | Action::Cancel(_) => None,
        });
        calls
            .enumerate()
            .map(move |(number, call)| (literal, number, call))
    });
    calls
        .map(|(literal, number, call)| LocationCall {
            state: match number {
                0 => format!("{state}_{}", label(&literal.declared)),
                more => format!("{state}_{}_{more}", label(&literal.declared)),
            },
            call,
        })
        .collect()
}

/// The calls of an actor.
pub(super) fn outputs_with_calls(actor: &Actor) -> impl Iterator<Item = (&ActorOutput, &Call)> {
    actor.outputs.iter().flat_map(|output| {
        let calls = calls(actor, output).into_iter();
        calls.map(move |it| (output, it.call))
    })
}

/// Returns `true` if the name of an event, as written in a binding, is that of an input.
pub(super) fn is_location(actor: &Actor, event: &str, input: &ActorInput) -> bool {
    let renamed = crate::rename::renamed(event, &actor.names);
    let without_spaces = |text: &str| text.replace(' ', "");
    without_spaces(&renamed) == without_spaces(&input.location)
}

/// The queue that the outcome of a call shares with messages.
fn queue_of(actor: &Actor, call: &Call) -> Option<String> {
    let event = call.event.as_deref()?;
    let mut inputs = actor.inputs.iter();
    let input = inputs.find(|it| is_location(actor, event, it))?;
    let has_queue = input.receive == Receive::All && input.origin != InputOrigin::Calls;
    has_queue.then(|| format!("waiting_{}", word(actor, input)))
}

/// Returns `true` if outcomes of an output's calls share a queue with messages.
pub(super) fn has_queue(actor: &Actor, output: &ActorOutput) -> bool {
    let calls = calls(actor, output);
    calls.iter().any(|it| queue_of(actor, it.call).is_some())
}

/// Rules for a queue of the verified specification whose oldest message was dropped: one message less is ahead of an outcome.
pub(super) fn shifted(actor: &Actor, queue: &str) -> Vec<String> {
    let shares = |output: &&ActorOutput| {
        let calls = calls(actor, output).into_iter();
        let mut queues = calls.filter_map(|it| queue_of(actor, it.call));
        queues.any(|it| it == queue)
    };
    let outputs = actor.outputs.iter().filter(shares);
    let ahead = outputs.map(|output| format!("ahead_{}", call_state(actor, output)));
    ahead
        .map(|ahead| format!("if {ahead} > 0 then {ahead} := {ahead} - 1 endif"))
        .collect()
}

/// Rules for queues that have been emptied: no message is ahead of an outcome any more.
pub(super) fn emptied(actor: &Actor, forgotten: &[String]) -> Vec<String> {
    let mut rules = Vec::new();
    for output in &actor.outputs {
        let queues = calls(actor, output).into_iter();
        let mut queues = queues.filter_map(|it| queue_of(actor, it.call));
        if queues.any(|queue| forgotten.contains(&format!("{queue} := []"))) {
            rules.push(format!("ahead_{} := 0", call_state(actor, output)));
        }
    }
    rules
}
