//! Ports, services and references of a specification that no binding uses.

use std::borrow::Cow;
use std::collections::BTreeSet;

use asmotion_component::BusHealth;
use asmotion_datum::Message;
use asmotion_diagnostics::Report;

use super::super::scene::CheckedComponent;
use crate::codes::c048::IdleKey;
use crate::finding::Findings;
use crate::model::binding::{Action, Argument, Bind, Effect, Source};
use crate::signature::Signature;

/// Reports the names that no binding uses. A specification that exchanges messages uses its services and references without
/// bindings, and annotations are compared with them elsewhere.
pub(super) fn check(part: &CheckedComponent<'_>, signature: &dyn Signature, report: &mut Report) {
    let Some(exchanges_messages) = signature.exchanges_messages() else {
        return;
    };
    let (component, used) = (part.component, Used::by(&part.bind));
    let mut idle = |key, at, reason| {
        report.found(IdleKey {
            key: Cow::Borrowed(key),
            at,
            reason,
        });
    };
    let annotations = signature.annotations();
    let is_annotated = !annotations.references.is_empty() || !annotations.provided.is_empty();
    if !exchanges_messages && !is_annotated {
        for service in &component.services {
            if !used.services.contains(&*service.name.value) {
                let reason = "never offered: no monitored function is bound to an operation of it with `service = \"NAME.OPERATION\"`";
                idle("services", service.name.span, reason);
            }
        }
        for reference in &component.references {
            if !used.references.contains(&*reference.name.value) {
                let reason = "never called: no literal of an out function has a `call` of it";
                idle("references", reference.name.span, reason);
            }
        }
    }
    for topic in &component.subscribe {
        // the channels of a specification are down while the bus is
        let is_health = topic.kind.value == BusHealth::NAME;
        if !is_health && !used.inputs.contains(&*topic.name.value) {
            let reason = "never read: no monitored function is bound to it with `topic`, and no message takes a value from it";
            idle("subscribe", topic.name.span, reason);
        }
    }
    for topic in &component.publish {
        if !used.outputs.contains(&*topic.name.value) {
            let reason = "never written: no out function is bound to it";
            idle("publish", topic.name.span, reason);
        }
    }
}

/// The names that bindings use.
#[derive(Default)]
struct Used<'b> {
    inputs: BTreeSet<&'b str>,
    outputs: BTreeSet<&'b str>,
    services: BTreeSet<&'b str>,
    references: BTreeSet<&'b str>,
}

impl<'b> Used<'b> {
    fn by(bind: &'b Bind) -> Self {
        let mut used = Self::default();
        for monitored in &bind.monitored {
            match &monitored.from {
                Source::Port(name) | Source::Losses(name) => {
                    used.inputs.insert(name);
                }
                Source::Request(operation) => {
                    used.services.insert(&operation.component);
                }
                Source::Timer { .. } | Source::Value(_) => {}
            }
            monitored
                .matching
                .iter()
                .for_each(|it| used.argument(&it.value));
        }
        for out in &bind.out {
            match &out.effect {
                Effect::Publish(published) => {
                    used.outputs.insert(&published.port);
                }
                Effect::Literals(cases) => {
                    let actions = cases.iter().flat_map(|(_, actions)| actions);
                    actions.for_each(|action| used.action(action));
                }
            }
        }
        used
    }

    fn action(&mut self, action: &'b Action) {
        match action {
            Action::Call(call) => {
                self.references.insert(&call.operation.component);
                self.services
                    .extend(call.reply.as_ref().map(|it| it.value.as_str()));
                call.with.iter().for_each(|it| self.argument(it));
            }
            Action::Publish { port, value } => {
                self.outputs.insert(port);
                self.argument(value);
            }
            Action::Cancel(_) => {}
        }
    }

    /// A name in an argument is that of a topic or of a kept reply.
    fn argument(&mut self, argument: &'b Argument) {
        match argument {
            Argument::Kept { name, .. } => {
                self.inputs.insert(name);
            }
            Argument::Record(_, fields) => fields.iter().for_each(|(_, it)| self.argument(it)),
            Argument::Term(_) | Argument::Value(_) => {}
        }
    }
}
