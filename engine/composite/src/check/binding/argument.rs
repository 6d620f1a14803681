//! Checks arguments of calls and fields of published messages.

use crate::codes::c099::UnknownKept;
use crate::codes::c115::UnknownField;
use crate::codes::c145::InvalidTerm;
use asmotion_datum::{OutlineKey, Schema, Shape};
use asmotion_diagnostics::Report;

use super::super::literal;
use super::{Bound, action, function};
use crate::at::At;
use crate::check::endpoints::EndpointPort;
use crate::finding::Findings;
use crate::model::binding::{Argument, Source};
use crate::table::NamedValue;

/// Checks that `argument` yields a value of type `wanted` for the port or operation `what`.
pub(super) fn check(
    bound: &Bound<'_>,
    what: &At<String>,
    argument: &Argument,
    wanted: Option<&Schema>,
    report: &mut Report,
) {
    match argument {
        Argument::Kept { name, path } => kept(bound, what, (name, path), wanted, report),
        Argument::Record(span, fields) => record(bound, what, (*span, fields), wanted, report),
        Argument::Term(term) => {
            let found = bound.signature.map(|signature| signature.term(term));
            match (found, wanted) {
                (Some(Err(reason)), _) => report.found(InvalidTerm {
                    term: term.value.clone(),
                    reason,
                    at: term.span,
                }),
                (Some(Ok(Some(found))), Some(wanted)) if !function::fits(&found, &wanted.shape) => {
                    let given = format!("`@({})`", term.value);
                    let found = format!("`{}`", found.name());
                    literal::wrong(what, wanted, &given, found, term.span, report);
                }
                (Some(Ok(_)) | None, _) => {}
            }
        }
        Argument::Value(node) => {
            if let Some(wanted) = wanted {
                literal::check(bound.scene.types, what, node, wanted, report);
            }
        }
    }
}

fn kept(
    bound: &Bound<'_>,
    what: &At<String>,
    (name, path): (&At<String>, &[At<String>]),
    wanted: Option<&Schema>,
    report: &mut Report,
) {
    let inputs = &bound.part.face.inputs;
    let input = inputs.iter().find(|port| port.name.text == name.value);
    let message = match input {
        Some(port) => schema(bound, port),
        None => match action::kept(bound, name)
            .or_else(|| asked(bound, name))
            .or_else(|| published(bound, name))
        {
            Some(response) => response,
            None => {
                let kept = bound.part.bind.calls();
                let kept = kept
                    .filter_map(|call| call.keep.as_ref())
                    .map(|it| it.value.clone());
                let outputs = &bound.part.face.outputs;
                let ports = inputs.iter().chain(outputs);
                let known = ports.map(|port| port.name.text.clone()).chain(kept);
                report.found(UnknownKept {
                    name: name.value.clone(),
                    at: name.span,
                    known: known.collect(),
                    is_function: bound
                        .signature
                        .is_some_and(|it| it.function(name).is_some()),
                });
                return;
            }
        },
    };
    let Some(message) = message else {
        return;
    };
    match bound.scene.types.within(message, path) {
        Err(error) => report.found(error),
        Ok(Some(found)) => {
            if let Some(wanted) = wanted
                && wanted.compare(&found).is_err()
            {
                let at = path.iter().fold(name.span, |span, step| span.to(step.span));
                let steps = path.iter().map(|step| format!(".{}", step.value));
                let given = format!("`@{}{}`", name.value, steps.collect::<String>());
                literal::wrong(what, wanted, &given, format!("`{found}`"), at, report);
            }
        }
        Ok(None) => {}
    }
}

/// Returns the message type of a port; `None` if it is unknown.
fn schema(bound: &Bound<'_>, port: &EndpointPort) -> Option<Schema> {
    let kind = port.kind.as_ref()?;
    bound.scene.types.schema(&kind.text)
}

/// Returns the message type of the output `name`: `None` if there is no such output, `Some(None)` if the type is unknown.
fn published(bound: &Bound<'_>, name: &str) -> Option<Option<Schema>> {
    let mut outputs = bound.part.face.outputs.iter();
    let output = outputs.find(|port| port.name.text == name)?;
    Some(schema(bound, output))
}

/// Returns the request type of the service bound to the monitored function `name`: `None` if there is no such binding,
/// `Some(None)` if the type is unknown.
fn asked(bound: &Bound<'_>, name: &str) -> Option<Option<Schema>> {
    let mut monitored = bound.part.bind.monitored.iter();
    let end = monitored.find_map(|monitored| match &monitored.from {
        Source::Request(end) if end.component.value == name => Some(end),
        Source::Request(_)
        | Source::Port(_)
        | Source::Timer { .. }
        | Source::Losses(_)
        | Source::Value(_) => None,
    })?;
    Some(function::request(bound, end, &mut Report::new()))
}

fn record(
    bound: &Bound<'_>,
    what: &At<String>,
    (span, fields): (asmotion_diagnostics::Span, &[(At<String>, Argument)]),
    wanted: Option<&Schema>,
    report: &mut Report,
) {
    let known = match wanted.map(|wanted| (wanted, &wanted.shape)) {
        Some((_, Shape::Record(known))) => Some(known.as_slice()),
        None | Some((_, Shape::Any)) => None,
        Some((wanted, _)) => {
            if !fields.is_empty() {
                literal::wrong(what, wanted, "this", "a table".to_owned(), span, report);
            }
            return;
        }
    };
    for (name, argument) in fields {
        field(bound, (name, argument), known, wanted, report);
    }
}

/// Checks the values that fields of a message of the type `message` must have.
pub(super) fn matching(
    bound: &Bound<'_>,
    matching: &[NamedValue<Argument>],
    message: Option<&Schema>,
    report: &mut Report,
) {
    let known = message.filter(|message| message.shape != Shape::Any);
    let known = known.map(|message| {
        if let Shape::Record(known) = &message.shape {
            known.as_slice()
        } else {
            &[]
        }
    });
    for NamedValue { name, value } in matching {
        field(bound, (name, value), known, message, report);
    }
}

/// Checks the value of a field of a record of the type `wanted`, whose fields are `known`.
fn field(
    bound: &Bound<'_>,
    (name, argument): (&At<String>, &Argument),
    known: Option<&[OutlineKey]>,
    wanted: Option<&Schema>,
    report: &mut Report,
) {
    let Some(known) = known else {
        check(bound, name, argument, None, report);
        return;
    };
    match known.iter().find(|field| field.name == name.value.as_str()) {
        Some(field) => check(bound, name, argument, Some(&field.schema), report),
        None => report.found(UnknownField {
            name: wanted.map(Schema::to_string).unwrap_or_default(),
            field: name.value.clone(),
            at: name.span,
            known: known.iter().map(|field| field.name.to_string()).collect(),
            declared: wanted.and_then(|wanted| bound.scene.types.declared(&wanted.name)),
        }),
    }
}
