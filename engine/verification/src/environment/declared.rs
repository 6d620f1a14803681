//! Locations of the environment for the inputs of an actor, and their initial values.

use super::EnvironmentWriter;
use super::calls::{is_location, outputs_with_calls};
use crate::actor::{Actor, ActorInput, InputOrigin, word};
use asmotion_coordinator::Receive;
use std::collections::BTreeSet;

impl EnvironmentWriter<'_> {
    /// Declares what the environment remembers for the inputs of an actor.
    pub(super) fn declare_inputs(&mut self, at: usize) {
        let Some(actor) = self.actor(at) else { return };
        self.glue.heading(&format!("inputs of {}", actor.component));
        let functions: BTreeSet<&String> = actor
            .functions
            .iter()
            .filter(|(_, facts)| facts.kind == asmotion_lang::syntax::ast::FunctionKind::Monitored)
            .map(|(name, _)| name)
            .collect();
        for function in functions {
            let bound = || actor.inputs.iter().filter(|it| it.function == *function);
            let facts = actor.functions.get(function);
            let locations = facts.map_or(Some(0), |facts| {
                let counts = facts.elements.iter();
                counts
                    .map(|it| it.as_ref().map(Vec::len))
                    .product::<Option<usize>>()
            });
            let is_complete = locations.is_some_and(|count| bound().count() == count);
            if let ([only], 0) = (bound().collect::<Vec<_>>().as_slice(), at)
                && let InputOrigin::Value(value) = &only.origin
                && only.location == *function
            {
                self.glue.fixed.insert(function.clone());
                self.glue.define(format!("function {function} = {value}"));
                continue;
            }
            let is_free = at == 0 && is_complete && bound().all(|it| self.can_be_free(actor, it));
            if !is_free {
                self.glue.controlled.insert(function.clone());
            }
        }
        for input in &actor.inputs {
            if self.is_set(at, &input.function) {
                self.declare_input(actor, input);
            }
        }
    }

    /// Returns `true` if an input can have any value in any step, whatever happened before.
    pub(super) fn can_be_free(&self, actor: &Actor, input: &ActorInput) -> bool {
        if let InputOrigin::Losses = input.origin {
            return input.codomain.is_boolean();
        }
        let alone = actor
            .inputs
            .iter()
            .filter(|it| it.origin == input.origin)
            .count()
            == 1;
        let has_port = match &input.origin {
            InputOrigin::Port(_) | InputOrigin::Request { .. } => true,
            InputOrigin::Calls
            | InputOrigin::Timer(_)
            | InputOrigin::Losses
            | InputOrigin::Value(_) => false,
        };
        let is_defined = input.receive == Receive::Edge
            || input.none.is_some() && input.stale.as_deref() != Some("undef");
        let takes_outcomes = outputs_with_calls(actor).any(|(_, call)| {
            call.event
                .as_deref()
                .is_some_and(|it| is_location(actor, it, input))
        });
        has_port
            && alone
            && is_defined
            && input.key.is_empty()
            && !takes_outcomes
            && self.is_open(0, input)
    }

    pub(super) fn declare_input(&mut self, actor: &Actor, input: &ActorInput) {
        let word = word(actor, input);
        let none = input.none.as_deref();
        match (&input.origin, input.receive) {
            (InputOrigin::Value(value), _) => self.start(actor, input, value),
            (InputOrigin::Timer(_), _) => self.start(actor, input, "false"),
            (InputOrigin::Losses, _) => {
                let value = if input.codomain.is_boolean() {
                    "false"
                } else {
                    "0"
                };
                self.start(actor, input, value);
            }
            (_, Receive::Edge) => {
                let text = format!("controlled arrived_{word}: Boolean");
                self.glue.declare(
                    &format!("a message for `{}` has arrived", input.location),
                    text,
                );
                self.glue.start(&format!("arrived_{word}"), "false");
                self.start(actor, input, "false");
            }
            (_, Receive::Last) => {
                let value = input.stale.as_deref().or(none);
                if let Some(value) = value.filter(|it| *it != "undef") {
                    self.start(actor, input, value);
                }
            }
            (origin, Receive::All) => {
                if *origin != InputOrigin::Calls {
                    let text = format!("controlled waiting_{word}: Seq({})", input.codomain.text);
                    self.glue.declare(
                        &format!("messages that wait for `{}`", input.location),
                        text,
                    );
                    self.glue.start(&format!("waiting_{word}"), "[]");
                }
                if let Some(value) = none {
                    self.start(actor, input, value);
                }
            }
        }
    }

    /// Sets the initial value of an input.
    pub(super) fn start(&mut self, actor: &Actor, input: &ActorInput, value: &str) {
        let facts = actor.functions.get(&input.function);
        let domain = facts.map_or("", |it| it.domain.as_str());
        self.glue
            .start_at(&input.function, domain, &input.location, value);
    }
}
