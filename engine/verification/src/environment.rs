//! The environment of a component's specification: what its inputs can be, according to the bindings of the composite and the
//! specifications and protocols of the other components.
//!
//! A step of the whole is a step of the verified specification, and then: its messages and calls take effect, the other
//! components make their steps, and the inputs of the next step are determined.

mod calls;
mod declared;
mod origins;
mod others;
mod received;
mod sent;

use crate::actor::{Actor, ActorInput, InputOrigin};
use crate::currency::Currency;
use crate::error::ModelError;
use crate::glue::{Glue, sequence};
use crate::network::{Senders, callers, writers};
use crate::rename::label;
use asmotion_composite::end::Terminal;
use asmotion_plan::{End, InputQueue, Plan};
use std::collections::{BTreeMap, BTreeSet};

/// Number of messages that can wait for an input with a queue of any size, or of none that is written.
pub(crate) const MAX_WAITING: u64 = 2;

/// Greatest size of a queue that is modelled as it is, whoever sends.
const MAX_EXACT_QUEUE: u64 = 8;

/// Size of the queue of a subscription, if the composite writes none. It drops the oldest message.
const UNWRITTEN_QUEUE: u64 = 256;

/// Writes the environment of the first of several actors.
pub(crate) struct EnvironmentWriter<'a> {
    pub plan: &'a Plan,
    pub actors: &'a [Actor],
    /// Answers that the protocols of service providers allow, by component, service and operation.
    pub answers: &'a BTreeMap<(String, String, String), Vec<String>>,
    pub glue: Glue,
    /// Assumptions of the environment beyond the bindings.
    pub notes: BTreeSet<String>,
    pub currency: Currency,
}

impl<'a> EnvironmentWriter<'a> {
    /// Writes the whole environment.
    ///
    /// # Errors
    /// The values of an input cannot be listed.
    pub fn write(&mut self) -> Result<(), ModelError> {
        let mut phases = Vec::new();
        for at in 0..self.actors.len() {
            self.declare_inputs(at);
        }
        self.declare_currency();
        for (at, actor) in self.actors.iter().enumerate() {
            let effects = self.effects(at)?;
            if at == 0 {
                phases.extend(self.named(actor, "effects", "effects of its last step", &effects));
                continue;
            }
            let receive = self.receive(at)?;
            phases.push(self.steps(at, &receive, &effects)?);
        }
        phases.extend(self.external_deliveries()?);
        let first = self.actors.first();
        if let Some(actor) = first {
            let receive = self.receive(0)?;
            phases.extend(self.named(actor, "receive", "inputs of its next step", &receive));
        }
        self.glue.rule(
            "all that happens between two steps",
            "r_environment",
            &sequence(&phases),
        );
        Ok(())
    }

    /// Adds a rule of an actor, and returns a call of it.
    pub(super) fn named(
        &mut self,
        actor: &Actor,
        what: &str,
        comment: &str,
        body: &[String],
    ) -> Option<String> {
        if body.is_empty() {
            return None;
        }
        let name = format!("r_{what}_{}", label(&actor.component));
        let comment = format!("{}: {comment}", actor.component);
        self.glue.rule(&comment, &name, &sequence(body));
        Some(format!("{name}[]"))
    }

    pub(super) fn actor(&self, at: usize) -> Option<&'a Actor> {
        self.actors.get(at)
    }

    /// The senders of an input's messages.
    pub(super) fn senders(&self, at: usize, input: &ActorInput) -> Senders {
        let Some(actor) = self.actor(at) else {
            return Senders::default();
        };
        senders(self.plan, actor, input)
    }

    /// Returns `true` if messages for an input can come from components that have no protocol, or from outside.
    pub(super) fn is_open(&self, at: usize, input: &ActorInput) -> bool {
        let senders = self.senders(at, input);
        let is_actor = |end: &End| {
            let mut actors = self.actors.iter();
            actors.any(|it| it.component == end.component && it.covers(&end.name))
        };
        senders.outside || senders.ends.iter().any(|end| !is_actor(end))
    }

    /// Returns the queue in which messages wait for an input of a specification. Between specifications it is that of the composite.
    /// From other senders, a queue that is too large for the model is cut off, which is noted as an assumption.
    pub(super) fn queue(&mut self, to: usize, receiver: &Actor, input: &ActorInput) -> InputQueue {
        let port = match (&input.origin, receiver.is_protocol) {
            (InputOrigin::Port(port), false) => Some(End {
                component: receiver.component.clone(),
                name: port.clone(),
            }),
            (_, _) => None,
        };
        let queue = port.and_then(|port| {
            let written = self.plan.input_queue(&port);
            written.or_else(|| self.unwritten_queue(&port))
        });
        let is_exact = |queue: &InputQueue| {
            queue.size <= MAX_EXACT_QUEUE || self.is_sent_by_specifications(to, input)
        };
        if let Some(queue) = queue.filter(is_exact) {
            return queue;
        }
        self.notes
            .insert(format!("at most {MAX_WAITING} messages wait for an input"));
        InputQueue {
            size: MAX_WAITING,
            is_circular: false,
        }
    }

    /// Returns the queue of an input port for which the composite writes none: its only connection keeps the newest message, or nothing
    /// is written for the topics that it subscribes to. `None` if several connections keep a message each.
    fn unwritten_queue(&self, port: &End) -> Option<InputQueue> {
        let connections = &self.plan.connections;
        let connected = |to: &Terminal| connections.to_end(to).count();
        let size = match connected(&Terminal::Port(port.clone())) {
            0 => {
                let mut topics = self.plan.topics.iter();
                let is_written = topics.any(|topic| {
                    topic.subscribers.contains(port)
                        && connected(&Terminal::Topic(topic.name.clone())) > 0
                });
                (!is_written).then_some(UNWRITTEN_QUEUE)
            }
            1 => Some(1),
            _ => None,
        };
        let is_circular = true;
        size.map(|size| InputQueue { size, is_circular })
    }

    /// Returns `true` if all messages for an input come from components that are modelled by their specifications.
    fn is_sent_by_specifications(&self, at: usize, input: &ActorInput) -> bool {
        let is_specification = |end: &End| {
            let mut actors = self.actors.iter();
            actors.any(|it| it.component == end.component && !it.is_protocol)
        };
        !self.is_open(at, input) && self.senders(at, input).ends.iter().all(is_specification)
    }

    /// Returns `true` if the environment sets an input of the verified specification; otherwise it has any value.
    pub(super) fn is_set(&self, at: usize, function: &str) -> bool {
        at > 0 || self.glue.controlled.contains(function)
    }

    fn declare_currency(&mut self) {
        for flag in self.currency.flags() {
            self.glue.declare(
                "the newest message of this input belongs to the last one that was published",
                format!("controlled {flag}: Boolean"),
            );
            self.glue.start(&flag, "false");
        }
    }
}

/// The senders of an input's messages.
pub(crate) fn senders(plan: &Plan, actor: &Actor, input: &ActorInput) -> Senders {
    senders_of(plan, &actor.component, &input.origin)
}

/// The senders of the messages from an origin.
pub(crate) fn senders_of(plan: &Plan, component: &str, origin: &InputOrigin) -> Senders {
    let end = |name: &str| End {
        component: component.to_owned(),
        name: name.to_owned(),
    };
    match origin {
        InputOrigin::Port(port) => writers(plan, &end(port)),
        InputOrigin::Request { service, .. } => callers(plan, &end(service)),
        InputOrigin::Calls
        | InputOrigin::Timer(_)
        | InputOrigin::Losses
        | InputOrigin::Value(_) => Senders::default(),
    }
}
