//! Checks wires to several services, which must not be used for calls that await a reply.

use std::borrow::Cow;

use crate::at::At;
use crate::codes::c034::AwaitsSeveral;
use crate::codes::c048::IdleKey;
use asmotion_datum::Shape;
use asmotion_diagnostics::{Report, Span};

use super::endpoints::EndpointService;
use super::scene::{CheckedComponent, CheckedComposite};
use crate::finding::Findings;
use crate::model::binding::{Action, Effect};
use crate::model::{Implementation, Wire};

/// Checks that no call through a reference wired to several services awaits a reply.
pub(super) fn check(
    scene: &CheckedComposite<'_>,
    wire: &Wire,
    part: &CheckedComponent<'_>,
    reference: &EndpointService,
    report: &mut Report,
) {
    if wire.services.len() < 2 {
        return;
    }
    if let Some((who, place)) = awaited(scene, wire, part, reference) {
        report.found(AwaitsSeveral {
            reference: wire.reference.to_string(),
            who,
            at: wire.reference.span(),
            place,
        });
    }
}

/// Reports keys of bindings about the reply to a one-way call.
pub(super) fn without_reply(part: &CheckedComponent<'_>, reference: &str, report: &mut Report) {
    for call in part.bind.calls() {
        if call.operation.component.value != reference {
            continue;
        }
        let faults = call.faults.first().map(|it| it.name.span);
        let place = |key: &Option<At<String>>| key.as_ref().map(|it| it.span);
        let keys = [
            ("keep", place(&call.keep)),
            ("ok", place(&call.ok)),
            ("failed", place(&call.failed)),
            ("faults", faults),
            ("timeout", place(&call.timeout)),
            ("unavailable", place(&call.unavailable)),
            ("event", place(&call.event)),
            ("reply", place(&call.reply)),
        ];
        for (key, at) in keys {
            if let Some(at) = at {
                report.found(IdleKey {
                    key: Cow::Borrowed(key),
                    at,
                    reason: "the wire is one-way, so there is no outcome",
                });
            }
        }
    }
}

/// Returns the component or binding that awaits a reply and its source location.
fn awaited(
    scene: &CheckedComposite<'_>,
    wire: &Wire,
    part: &CheckedComponent<'_>,
    reference: &EndpointService,
) -> Option<(String, Option<Span>)> {
    let name = &wire.reference.name.value;
    by_binding(part, name)
        .or_else(|| by_specification(scene, part, name))
        .or_else(|| match &wire.oneway {
            Some(oneway) if !oneway.value => {
                Some(("the wire expects a reply".to_owned(), Some(oneway.span)))
            }
            Some(_) => None,
            None => by_interface(scene, reference),
        })
}

/// Returns the binding that keeps a reply or reports its arrival.
fn by_binding(part: &CheckedComponent<'_>, reference: &str) -> Option<(String, Option<Span>)> {
    let effects = part.bind.out.iter().map(|out| &out.effect);
    let actions = effects.flat_map(|effect| match effect {
        Effect::Literals(cases) => cases.iter().flat_map(|(_, actions)| actions).collect(),
        Effect::Publish(_) => Vec::new(),
    });
    for action in actions {
        let Action::Call(call) = action else {
            continue;
        };
        let names = [&call.keep, &call.event].into_iter().flatten();
        if call.operation.component.value == reference
            && let Some(place) = names.chain(call.literals()).next()
        {
            let who = format!("its binding waits for `{}`", call.operation);
            return Some((who, Some(place.span)));
        }
    }
    None
}

/// Returns the specification of the caller if a reply sets one of its functions.
fn by_specification(
    scene: &CheckedComposite<'_>,
    part: &CheckedComponent<'_>,
    reference: &str,
) -> Option<(String, Option<Span>)> {
    let Some(Implementation::Asm { file, .. }) = &part.component.implementation else {
        return None;
    };
    let signature = scene.family.specification(scene.member, file)?;
    let (operation, place) = signature.awaits(reference)?;
    let who = format!("its specification waits for the reply to `{operation}`");
    Some((who, Some(place)))
}

/// Returns the interface if one of its operations has a reply.
fn by_interface(
    scene: &CheckedComposite<'_>,
    reference: &EndpointService,
) -> Option<(String, Option<Span>)> {
    let interface = &reference.interface.text;
    let operations = scene.catalogue.operations(interface)?;
    let says_something = |shape: &Shape| {
        if let Shape::Record(fields) = shape {
            !fields.is_empty()
        } else {
            *shape != Shape::Any
        }
    };
    let answers = operations
        .iter()
        .find(|it| says_something(&it.response.shape))?;
    let who = format!(
        "`{}` of `{interface}` returns `{}`",
        answers.name, answers.response
    );
    Some((who, None))
}
