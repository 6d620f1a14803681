//! Sources of the values of inputs, for readers.

use super::EnvironmentWriter;
use super::calls::{is_location, outputs_with_calls};
use crate::actor::{Actor, ActorInput, InputOrigin, OutputEffect};
use crate::origin::ValueOrigin;
use std::collections::BTreeMap;

impl EnvironmentWriter<'_> {
    /// Sources of the values of each input of the verified specification.
    pub fn origins(&self) -> BTreeMap<String, Vec<ValueOrigin>> {
        let Some(actor) = self.actor(0) else {
            return BTreeMap::new();
        };
        let inputs = actor.inputs.iter();
        inputs
            .map(|input| (input.location.clone(), self.origins_of(actor, input)))
            .collect()
    }

    pub(super) fn origins_of(&self, actor: &Actor, input: &ActorInput) -> Vec<ValueOrigin> {
        let mut origins = Vec::new();
        let senders = self.senders(0, input);
        let through = match &input.origin {
            InputOrigin::Port(port) => format!("input {port}"),
            InputOrigin::Request { service, operation } => format!("{service}.{operation}"),
            InputOrigin::Timer(condition) => format!("timer: {condition}"),
            InputOrigin::Losses => "lost messages".to_owned(),
            InputOrigin::Calls | InputOrigin::Value(_) => String::new(),
        };
        for end in &senders.ends {
            let sender = self
                .actors
                .iter()
                .skip(1)
                .find(|it| it.component == end.component);
            let outputs = sender.into_iter().flat_map(|it| &it.outputs);
            let sent = outputs.filter(|it| match &it.effect {
                OutputEffect::Publish { port, .. } => *port == end.name,
                OutputEffect::Send { reference, .. } => *reference == end.name,
                OutputEffect::Reply { .. } | OutputEffect::Cases(_) => false,
            });
            let elements = sent.flat_map(|it| it.codomain.elements.iter().flatten());
            let values: Vec<String> = elements
                .filter_map(|it| Some(input.codomain.named(&it.declared)?.name.clone()))
                .collect();
            origins.push(ValueOrigin {
                values: (!values.is_empty()).then_some(values),
                from: end.to_string(),
            });
        }
        if senders.outside {
            origins.push(ValueOrigin {
                values: None,
                from: format!("outside, {through}"),
            });
        }
        if senders.ends.is_empty() && !senders.outside && !through.is_empty() {
            origins.push(ValueOrigin {
                values: None,
                from: through,
            });
        }
        for (_, call) in outputs_with_calls(actor) {
            if call
                .event
                .as_deref()
                .is_some_and(|it| is_location(actor, it, input))
            {
                let outcomes = self.outcomes(actor, call).into_iter().flatten();
                origins.push(ValueOrigin {
                    values: Some(outcomes.collect()),
                    from: format!("call {}", call.operation),
                });
            }
        }
        origins
    }
}
