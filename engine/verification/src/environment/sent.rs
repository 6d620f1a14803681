//! Messages that an actor sends: the effects of its last step, and how messages reach inputs.

use super::EnvironmentWriter;
use super::calls::{call_state, calls, emptied, shifted};
use crate::actor::{Actor, ActorInput, ActorOutput, InputOrigin, OutputEffect, word};
use crate::error::ModelError;
use crate::glue::{parameters, sequence};
use crate::message::{SentMessage, SentValue, TakenValue};
use asmotion_coordinator::{PublishWhen, Receive};
use asmotion_plan::{End, InputQueue};
use std::collections::BTreeSet;

impl EnvironmentWriter<'_> {
    /// The rules for the effects of an actor's last step.
    pub(super) fn effects(&mut self, at: usize) -> Result<Vec<String>, ModelError> {
        let Some(actor) = self.actor(at) else {
            return Ok(Vec::new());
        };
        let mut rules = Vec::new();
        if at == 0 {
            let calling = actor
                .outputs
                .iter()
                .filter(|output| !calls(actor, output).is_empty());
            rules.extend(
                calling.map(|output| format!("renewed_{} := false", call_state(actor, output))),
            );
        }
        for (index, output) in actor.outputs.iter().enumerate() {
            let x = &output.location;
            let message = message_outputs(actor, index);
            let effect = match &output.effect {
                // sent with the first output of the message
                OutputEffect::Publish { .. } if message.first() != Some(&index) => Vec::new(),
                OutputEffect::Publish { port, key, .. } => {
                    let message = SentMessage::Values {
                        is_complete: !actor.is_protocol,
                        values: values(actor, &message),
                        key,
                        contents: actor.own_messages.on(port),
                    };
                    self.publish(at, port, &message)?
                }
                OutputEffect::Send {
                    reference,
                    operation,
                    field,
                } => {
                    let value = SentValue {
                        field: field.as_deref(),
                        term: x,
                        codomain: &output.codomain,
                    };
                    let message = SentMessage::Values {
                        is_complete: !actor.is_protocol,
                        values: vec![value],
                        key: &[],
                        contents: &[],
                    };
                    self.request(at, reference, operation, &message)?
                }
                OutputEffect::Reply { .. } => Vec::new(),
                OutputEffect::Cases(cases) => self.cases(at, actor, output, cases)?,
            };
            if effect.is_empty() {
                continue;
            }
            self.effect(actor, &message, effect, &mut rules);
        }
        for output in &actor.outputs {
            rules.extend(self.silent_ends(actor, output));
        }
        Ok(rules)
    }

    /// The rules for the effect of an update of these outputs.
    fn effect(
        &mut self,
        actor: &Actor,
        message: &[usize],
        effect: Vec<String>,
        rules: &mut Vec<String>,
    ) {
        let outputs = message.iter().filter_map(|it| actor.outputs.get(*it));
        let outputs: Vec<(&ActorOutput, PublishWhen)> = outputs.map(|it| (it, when(it))).collect();
        if outputs.iter().any(|(_, it)| *it == PublishWhen::EveryStep) {
            rules.extend(effect);
            return;
        }
        let mut given = Vec::new();
        for (output, when) in outputs {
            self.declare_given(actor, output, when == PublishWhen::OnChange);
            let (function, x) = (&output.function, &output.location);
            let arguments = x.strip_prefix(function.as_str()).unwrap_or_default();
            given.push(format!("given_{function}{arguments}"));
        }
        let forgotten = given.iter().map(|it| format!("{it} := false"));
        let effects: Vec<String> = forgotten.chain(effect).collect();
        rules.push(format!(
            "if {} then {} endif",
            given.join(" or "),
            sequence(&effects)
        ));
    }

    /// Declares that updates of an out function are noted.
    fn declare_given(&mut self, actor: &Actor, output: &ActorOutput, only_changes: bool) {
        let function = &output.function;
        let known = self.glue.given.get(function).copied();
        self.glue
            .given
            .insert(function.clone(), known.unwrap_or(true) && only_changes);
        if known.is_some() {
            return;
        }
        let domain = actor
            .functions
            .get(function)
            .map_or("", |it| it.domain.as_str());
        let (arrow, parameters) = match domain {
            "" => (String::new(), String::new()),
            domain => (format!("{domain} -> "), parameters(domain)),
        };
        self.glue.declare(
            &format!("the last step of {} updated `{function}`", actor.component),
            format!("controlled given_{function}: {arrow}Boolean"),
        );
        self.glue
            .start(&format!("given_{function}{parameters}"), "false");
    }

    /// The rules for a message on an output port.
    pub(super) fn publish(
        &mut self,
        at: usize,
        port: &str,
        message: &SentMessage<'_>,
    ) -> Result<Vec<String>, ModelError> {
        let Some(actor) = self.actor(at) else {
            return Ok(Vec::new());
        };
        let end = End {
            component: actor.component.clone(),
            name: port.to_owned(),
        };
        let mut rules = Vec::new();
        if at == 0 {
            let forgotten = self.currency.forget(port, actor);
            let emptied = emptied(actor, &forgotten);
            rules.extend(forgotten);
            rules.extend(emptied);
        }
        for (to, receiver) in self.actors.iter().enumerate() {
            let mut marked = BTreeSet::new();
            for input in &receiver.inputs {
                let InputOrigin::Port(name) = &input.origin else {
                    continue;
                };
                if !self.is_set(to, &input.function) || !self.senders(to, input).ends.contains(&end)
                {
                    continue;
                }
                if marked.insert(name.clone()) {
                    rules.extend(self.currency.pass_on(actor, at, port, receiver, name));
                }
                rules.extend(self.deliver(to, receiver, input, message, Some((actor, port)))?);
            }
        }
        Ok(rules)
    }

    /// The rules for a request.
    pub(super) fn request(
        &mut self,
        at: usize,
        reference: &str,
        operation: &str,
        message: &SentMessage<'_>,
    ) -> Result<Vec<String>, ModelError> {
        let Some(actor) = self.actor(at) else {
            return Ok(Vec::new());
        };
        let end = End {
            component: actor.component.clone(),
            name: reference.to_owned(),
        };
        let mut rules = Vec::new();
        for (to, receiver) in self.actors.iter().enumerate() {
            for input in &receiver.inputs {
                let InputOrigin::Request {
                    operation: requested,
                    ..
                } = &input.origin
                else {
                    continue;
                };
                let is_it = requested == operation && self.senders(to, input).ends.contains(&end);
                if is_it && self.is_set(to, &input.function) {
                    rules.extend(self.deliver(
                        to,
                        receiver,
                        input,
                        message,
                        Some((actor, reference)),
                    )?);
                }
            }
        }
        Ok(rules)
    }

    /// The rule that hands a message to an input; `None` if it cannot be for it.
    pub(super) fn deliver(
        &mut self,
        to: usize,
        receiver: &Actor,
        input: &ActorInput,
        message: &SentMessage<'_>,
        from: Option<(&Actor, &str)>,
    ) -> Result<Option<String>, ModelError> {
        let selected = message.selects(input);
        if selected == Some(false) {
            return Ok(None);
        }
        let word = word(receiver, input);
        let needs_value = input.receive != Receive::Edge || !input.is.is_empty();
        let (value, misfits, choice) = match message.value(input) {
            TakenValue::Term(text, misfits) => (text, misfits, None),
            TakenValue::Unknown if needs_value => {
                let domain = self.listed(receiver, input)?;
                ("$unknown".to_owned(), false, Some(domain))
            }
            TakenValue::Unknown => ("true".to_owned(), false, None),
        };
        let mut rule = match input.receive {
            Receive::Edge if needs_value => format!("if {value} then arrived_{word} := true endif"),
            Receive::Edge => format!("arrived_{word} := true"),
            Receive::Last => format!("{} := {value}", input.location),
            Receive::All => {
                let waiting = format!("waiting_{word}");
                let queue = self.queue(to, receiver, input);
                let ahead = if to == 0 {
                    shifted(receiver, &waiting)
                } else {
                    Vec::new()
                };
                queued(queue, &waiting, &value, ahead)
            }
        };
        if misfits && needs_value {
            rule = format!("if isDef({value}) then {rule} endif");
        }
        if let Some(domain) = choice {
            rule = format!("choose $unknown in {domain} do {rule}");
        }
        let condition = self.currency.condition(to, input, from);
        if let Some(term) = condition.term {
            rule = format!("if {term} then {rule} endif");
        }
        if condition.is_uncertain || selected.is_none() {
            rule = format!("choose $fits in Boolean do if $fits then {rule} endif");
        }
        Ok(Some(rule))
    }

    /// The domain of an input, if its values can be listed.
    pub(super) fn listed(&self, actor: &Actor, input: &ActorInput) -> Result<String, ModelError> {
        let text = &input.codomain.text;
        let is_listed = input.codomain.is_boolean() || input.codomain.elements.is_some();
        let is_named = text
            .chars()
            .all(|sign| sign.is_alphanumeric() || sign == '_');
        let is_basic =
            ["Integer", "Natural", "Real", "String", "Char", "Complex"].contains(&text.as_str());
        if is_listed || is_named && !is_basic {
            return Ok(text.clone());
        }
        Err(ModelError::Unbounded {
            component: actor.component.clone(),
            input: input.location.clone(),
        })
    }
}

/// When the message of an output is sent.
fn when(output: &ActorOutput) -> PublishWhen {
    match &output.effect {
        OutputEffect::Publish { when, .. } => *when,
        OutputEffect::Send { .. } | OutputEffect::Reply { .. } | OutputEffect::Cases(_) => {
            PublishWhen::OnUpdate
        }
    }
}

/// The outputs in whose message that at this position is sent: those of the same port and key with a field each.
fn message_outputs(actor: &Actor, index: usize) -> Vec<usize> {
    let target = |output: &ActorOutput| match &output.effect {
        OutputEffect::Publish {
            port,
            field: Some(_),
            key,
            ..
        } if !actor.is_protocol => Some((port.clone(), key.clone())),
        OutputEffect::Publish { .. }
        | OutputEffect::Send { .. }
        | OutputEffect::Reply { .. }
        | OutputEffect::Cases(_) => None,
    };
    let Some(wanted) = actor.outputs.get(index).and_then(target) else {
        return vec![index];
    };
    let all = actor.outputs.iter().enumerate();
    let same = all.filter(|(_, output)| target(output).as_ref() == Some(&wanted));
    let same: Vec<usize> = same.map(|(at, _)| at).collect();
    let mut fields: Vec<Option<&str>> = values(actor, &same).iter().map(|it| it.field).collect();
    fields.sort_unstable();
    fields.dedup();
    // several values for one field are several messages
    if fields.len() < same.len() {
        return vec![index];
    }
    same
}

/// The values of outputs in a message.
fn values<'a>(actor: &'a Actor, message: &[usize]) -> Vec<SentValue<'a>> {
    let outputs = message.iter().filter_map(|it| actor.outputs.get(*it));
    let value = |output: &'a ActorOutput| {
        let field = match &output.effect {
            OutputEffect::Publish { field, .. } => field.as_deref(),
            OutputEffect::Send { .. } | OutputEffect::Reply { .. } | OutputEffect::Cases(_) => None,
        };
        SentValue {
            field,
            term: &output.location,
            codomain: &output.codomain,
        }
    };
    outputs.map(value).collect()
}

/// The rule that puts a value into a queue. If the queue is full, it drops the value, or the oldest one with further effects.
fn queued(queue: InputQueue, waiting: &str, value: &str, dropped: Vec<String>) -> String {
    let InputQueue { size, is_circular } = queue;
    let otherwise = if is_circular {
        let shift = format!("{waiting} := append(tail({waiting}), {value})");
        let rules: Vec<String> = std::iter::once(shift).chain(dropped).collect();
        format!("else par {} endpar ", rules.join(" "))
    } else {
        String::new()
    };
    format!(
        "if length({waiting}) < {size} then {waiting} := append({waiting}, {value}) {otherwise}endif"
    )
}
