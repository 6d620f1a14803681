//! Checks the actions triggered by updates of out functions: calls and published messages.

use std::borrow::Cow;

use crate::codes::c048::IdleKey;
use crate::codes::c091::WrongFunctionKind;
use asmotion_datum::Schema;
use asmotion_diagnostics::{Report, Span};

use super::{Bound, argument, function};
use crate::at::At;
use crate::check::component::unknown;
use crate::check::endpoints::{find, nearest_service};
use crate::finding::Findings;
use crate::model::binding::{Action, Bind, Call};
use crate::nearest::nearest;
use crate::signature::FunctionKind;

/// Names of the functions that receive the outcome of calls.
pub(super) fn events(bind: &Bind) -> Vec<&At<String>> {
    bind.calls()
        .filter_map(|call| call.event.as_ref())
        .collect()
}

pub(super) fn check(bound: &Bound<'_>, action: &Action, report: &mut Report) {
    match action {
        Action::Call(call) => self::call(bound, call, report),
        Action::Publish { port, value } => {
            let kind = function::output(bound, port, report).and_then(|port| port.kind.as_ref());
            let schema = kind.and_then(|kind| bound.scene.types.schema(&kind.text));
            argument::check(bound, port, value, schema.as_ref(), report);
        }
        Action::Cancel(_) => {}
    }
}

/// Reports the keys `cancel` without an effect among the actions of the values of an out function.
pub(super) fn idle_cancels(cases: &[(At<String>, Vec<Action>)], report: &mut Report) {
    let mut actions = cases.iter().flat_map(|(_, actions)| actions);
    let makes_calls = actions.any(|action| matches!(action, Action::Call(_)));
    for (_, actions) in cases {
        for action in actions {
            let Action::Cancel(cancel) = action else {
                continue;
            };
            let reason = if !cancel.value {
                "an update to a value without an action cancels no call"
            } else if !makes_calls {
                "no value of this function makes a call"
            } else if actions.len() > 1 {
                "the other actions of this value cancel the call already"
            } else {
                continue;
            };
            report.found(IdleKey {
                key: Cow::Borrowed("cancel"),
                at: cancel.span,
                reason,
            });
        }
    }
}

fn call(bound: &Bound<'_>, call: &Call, report: &mut Report) {
    let wanted = operation(bound, call, report);
    if let Some(with) = &call.with {
        argument::check(bound, &call.operation.name, with, wanted.as_ref(), report);
    }
    if let Some(service) = &call.reply {
        let services = &bound.part.face.services;
        if find(services, service).is_none() {
            report.found(unknown(
                "service",
                service,
                nearest_service(services, service),
            ));
        }
    }
    let Some(event) = &call.event else {
        return;
    };
    let Some(signature) = bound.signature else {
        return;
    };
    let Some(told) = function::location(signature, event, &[], report) else {
        return;
    };
    if !matches!(told.kind, FunctionKind::Monitored | FunctionKind::Shared) {
        let at: Span = event.span;
        report.found(WrongFunctionKind {
            function: told.clone(),
            reason: "a reply cannot change it",
            help: "name a monitored function",
            at,
        });
        return;
    }
    for literal in call.literals() {
        function::literal(told, literal, report);
    }
}

/// Returns the argument type of the called operation; `None` if the catalogue does not know it.
fn operation(bound: &Bound<'_>, call: &Call, report: &mut Report) -> Option<Schema> {
    let references = &bound.part.face.references;
    let name: &At<String> = &call.operation.component;
    let Some(reference) = find(references, name) else {
        report.found(unknown(
            "reference",
            name,
            nearest_service(references, name),
        ));
        return None;
    };
    let operations = bound
        .scene
        .catalogue
        .operations(&reference.interface.text)?;
    let name = &call.operation.name;
    let found = operations
        .iter()
        .find(|operation| operation.name == name.value);
    if found.is_none() {
        let known = operations
            .iter()
            .map(|operation| (operation.name.as_str(), None));
        report.found(unknown("operation", name, nearest(name, known)));
    }
    found.map(|operation| operation.request.clone())
}

/// Returns the type of the reply kept under `name`: `None` if no call keeps such a reply, `Some(None)` if its type is
/// unknown.
pub(super) fn kept(bound: &Bound<'_>, name: &str) -> Option<Option<Schema>> {
    let keeps = |call: &&Call| call.keep.as_ref().is_some_and(|keep| keep.value == name);
    let call = bound.part.bind.calls().find(keeps)?;
    let reference = find(&bound.part.face.references, &call.operation.component);
    let operations = reference.and_then(|it| bound.scene.catalogue.operations(&it.interface.text));
    let operation = operations
        .into_iter()
        .flatten()
        .find(|operation| operation.name == call.operation.name.value);
    Some(operation.map(|operation| operation.response))
}
