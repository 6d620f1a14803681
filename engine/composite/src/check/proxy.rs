//! Checks port-proxies: the mapping from operations to ports of the target, and the notifications.

use crate::codes::c120::WrongPortDirection;
use crate::codes::c121::PortOfOtherComponent;
use crate::codes::c124::ShapeMismatch;
use crate::codes::c125::InvalidCondition;
use crate::codes::c126::NoIdleNotification;
use crate::codes::c127::StaleWithoutPeriod;
use asmotion_component::declaration::OperationDeclaration;
use asmotion_datum::{Schema, Shape, Word as _};
use asmotion_diagnostics::{Report, Span};

use super::builtin::missing;
use super::component::unknown;
use super::endpoints::{
    EndpointPort, EndpointService, Endpoints, NamedAt, PortDirection, TypeAt, find, nearest_service,
};
use super::scene::CheckedComposite;
use crate::at::At;
use crate::finding::Findings;
use crate::map;
use crate::model::{
    Component, Condition, ListLength, MapEntry, MessagePath, Notify, ProxyEntry, ProxyMode,
};
use crate::nearest::nearest;

/// Checks a port-proxy and adds ports mirroring those of its target: an input of the target is an output of the proxy.
pub(super) fn check(
    scene: &CheckedComposite<'_>,
    component: &Component,
    target: Option<&At<String>>,
    listed: &Endpoints,
    report: &mut Report,
) -> Option<Endpoints> {
    let Some(target) = target else {
        let example = "\"youBotDriver\"";
        missing(component, "target", example, "a port-proxy", report);
        return None;
    };
    let is_unknown = scene.part(target, report)?.face.blank;
    let mut face = listed.clone();
    for entry in &component.special.map {
        if let MapEntry::Proxy(entry) = entry {
            mirror(scene, entry, target, &mut face, report);
            motion(entry, component.special.notify.as_ref(), report);
        }
    }
    for length in &component.special.lengths {
        if is_unknown {
            continue;
        }
        if let Some(on) = length.on.as_ref().and_then(|on| on.steps.first()) {
            mirror_state(scene, target, on, &mut face, report);
        }
        list_length(scene, length, &face, report);
    }
    if let Some(told) = &component.special.notify {
        if !is_unknown {
            notify(scene, told, &face, report);
        }
        pace(scene, component, told, report);
    }
    Some(face)
}

/// The way out of an invalid condition.
const CONDITION_HELP: &str =
    "write `port.new`, `port.flag`, or `port.field != 0` with `==`, `!=`, `<`, `<=`, `>` or `>=`";

fn mirror(
    scene: &CheckedComposite<'_>,
    entry: &ProxyEntry,
    target: &At<String>,
    face: &mut Endpoints,
    report: &mut Report,
) {
    let service = &entry.operation.component;
    let declared = match find(&face.services, service) {
        Some(provided) => operation(scene, entry, &provided.interface.text, report),
        None => {
            let nearest = nearest_service(&face.services, service);
            report.found(unknown("service", service, nearest));
            None
        }
    };
    if entry.port.component.value != target.value {
        report.found(PortOfOtherComponent {
            port: entry.port.to_string(),
            target: target.value.clone(),
            at: entry.port.span(),
            target_at: target.span,
        });
        return;
    }
    let wanted = match entry.mode.value {
        ProxyMode::Oneway | ProxyMode::Taken | ProxyMode::Done => PortDirection::In,
        ProxyMode::Last | ProxyMode::All => PortDirection::Out,
    };
    let Some((_, way, port)) = scene.port(&entry.port, wanted, report) else {
        return;
    };
    if way != wanted {
        report.found(WrongPortDirection {
            mode: entry.mode.value.word(),
            wanted: wanted.word(),
            found: way.word(),
            port: entry.port.to_string(),
            at: entry.port.name.span,
            declared: port.name.at,
        });
        return;
    }
    if let Some(kind) = &port.kind {
        shapes(scene, entry, kind, declared.as_ref(), report);
    }
    let mirror = match way {
        PortDirection::In => PortDirection::Out,
        PortDirection::Out => PortDirection::In,
    };
    if face
        .port(&entry.port.name, mirror)
        .is_some_and(|(found, _)| found == mirror)
    {
        return;
    }
    let mirrored = EndpointPort {
        name: NamedAt::new(&entry.port.name.value, Some(entry.port.name.span)),
        kind: port.kind.clone(),
        topic: None,
        listed: true,
        optional: false,
    };
    match way {
        PortDirection::In => face.outputs.push(mirrored),
        PortDirection::Out => face.inputs.push(mirrored),
    }
}

/// Adds an input for an output of the target that only `lengths` names. An unknown port is reported with its field.
fn mirror_state(
    scene: &CheckedComposite<'_>,
    target: &At<String>,
    port: &At<String>,
    face: &mut Endpoints,
    report: &mut Report,
) {
    let is_known = |face: &Endpoints| {
        face.port(port, PortDirection::In)
            .is_some_and(|(found, _)| found == PortDirection::In)
    };
    if is_known(face) {
        return;
    }
    let Some(part) = scene.part(target, report) else {
        return;
    };
    if let Some((PortDirection::Out, found)) = part.face.port(port, PortDirection::Out) {
        face.inputs.push(EndpointPort {
            name: NamedAt::new(&port.value, Some(port.span)),
            kind: found.kind.clone(),
            topic: None,
            listed: true,
            optional: false,
        });
    }
}

/// Checks that both sides of an entry of `lengths` are lists.
fn list_length(
    scene: &CheckedComposite<'_>,
    length: &ListLength,
    face: &Endpoints,
    report: &mut Report,
) {
    for path in [Some(&length.of), length.on.as_ref()].into_iter().flatten() {
        if let Some((schema, declared)) = field(scene, path, face, report)
            && !matches!(schema.shape, Shape::List(_) | Shape::Array(..) | Shape::Any)
        {
            report.found(InvalidCondition {
                reason: format!("`{path}` is not a list"),
                found: format!("has type `{schema}`"),
                help: "name a list of a command with `of`, and a list of the target's state with `on`",
                at: path.span,
                declared,
            });
        }
    }
}

/// Returns the operation of an entry if the catalogue knows its interface; reports an unknown operation.
fn operation(
    scene: &CheckedComposite<'_>,
    entry: &ProxyEntry,
    interface: &str,
    report: &mut Report,
) -> Option<OperationDeclaration> {
    let name = &entry.operation.name;
    let operations = scene.catalogue.operations(interface)?;
    let found = operations.iter().find(|known| known.name == name.value);
    if found.is_none() {
        let known = operations.iter().map(|known| (known.name.as_str(), None));
        report.found(unknown("operation", name, nearest(name, known)));
    }
    found.cloned()
}

/// Checks that the argument or result of the operation is convertible to or from the message type.
fn shapes(
    scene: &CheckedComposite<'_>,
    entry: &ProxyEntry,
    kind: &TypeAt,
    operation: Option<&OperationDeclaration>,
    report: &mut Report,
) {
    if let Some(field) = &entry.field
        && let Err(error) = scene.types.field(&kind.text, field)
    {
        report.found(error);
        return;
    }
    let (Some(operation), Some(message)) = (operation, scene.types.schema(&kind.text)) else {
        return;
    };
    if map::conversion(entry, operation, &message).is_some() {
        return;
    }
    let (what, argument) = match entry.mode.value {
        ProxyMode::Oneway | ProxyMode::Taken | ProxyMode::Done => ("the argument", true),
        ProxyMode::Last | ProxyMode::All => ("the result", false),
    };
    let (mine, named) = if argument {
        (&operation.request, &message)
    } else {
        (&operation.response, &message)
    };
    report.found(ShapeMismatch {
        what,
        operation: entry.operation.to_string(),
        wanted: match (argument, &entry.field) {
            (_, Some(field)) => format!("`{field}` of a `{named}`"),
            (true, None) => format!("`{named}`"),
            (false, None) => format!("part of a `{named}`"),
        },
        here: format!("`{}`", mine.shape),
        there: format!("`{}`", named.shape),
        at: entry.operation.span(),
        declared: scene.types.declared(&kind.text).or(kind.at),
    });
}

/// Checks that an entry with mode `done` has an `idle` condition that detects the end of a motion.
fn motion(entry: &ProxyEntry, told: Option<&Notify>, report: &mut Report) {
    if entry.mode.value != ProxyMode::Done {
        return;
    }
    let idle = told.and_then(|told| told.idle.as_ref());
    let port = &entry.port.name;
    let of = idle.and_then(|idle| idle.of.steps.first());
    if of.is_none_or(|of| of.value != port.value) {
        report.found(NoIdleNotification {
            port: port.value.clone(),
            at: entry.mode.span,
            idle: idle.map(|idle| idle.of.span),
        });
    }
}

/// Checks that a proxy with `stale_ms` has a period; an event-driven component would not notice missing messages.
fn pace(scene: &CheckedComposite<'_>, component: &Component, told: &Notify, report: &mut Report) {
    let Some(stale_ms) = &told.stale_ms else {
        return;
    };
    if !scene.cycles_by_time(component) {
        report.found(StaleWithoutPeriod {
            key: "stale_ms",
            component: component.name.value.clone(),
            at: stale_ms.span,
            declared: component.name.span,
        });
    }
}

/// Checks that the notified reference exists and the conditions are valid.
fn notify(scene: &CheckedComposite<'_>, told: &Notify, face: &Endpoints, report: &mut Report) {
    match find(&face.references, &told.reference) {
        None => {
            let nearest = nearest_service(&face.references, &told.reference);
            report.found(unknown("reference", &told.reference, nearest));
        }
        Some(reference) => listener(scene, told, reference, report),
    }
    for path in told.idle.iter().flat_map(|idle| [&idle.of, &idle.on]) {
        if let Some((schema, at)) = field(scene, path, face, report)
            && !is_number(&schema)
        {
            let reason = format!("`{path}` is neither a number nor a list of numbers");
            condition(reason, &schema, path.span, at, report);
        }
    }
    for told in told.refresh.iter().chain(&told.fault) {
        asked(scene, told, face, report);
    }
}

/// Checks that the notified interface has an operation that accepts an event.
fn listener(
    scene: &CheckedComposite<'_>,
    told: &Notify,
    reference: &EndpointService,
    report: &mut Report,
) {
    let interface = &reference.interface;
    let Some(operations) = scene.catalogue.operations(&interface.text) else {
        return;
    };
    if map::listener(&operations).is_none() {
        report.found(ShapeMismatch {
            what: "no operation",
            operation: interface.text.clone(),
            wanted: "listener of events".to_owned(),
            here: format!("`{}`", map::notice().shape),
            there: "the interface".to_owned(),
            at: told.reference.span,
            declared: interface.at,
        });
    }
}

/// Parses a condition and checks it against the message type of its port.
fn asked(scene: &CheckedComposite<'_>, told: &Condition, face: &Endpoints, report: &mut Report) {
    let read = match told.text.parse::<asmotion_bridge::MessageCondition>() {
        Ok(read) => read,
        Err(error) => {
            report.found(InvalidCondition {
                reason: error.to_string(),
                found: "cannot be parsed".to_owned(),
                help: CONDITION_HELP,
                at: told.text.span,
                declared: None,
            });
            return;
        }
    };
    let Some(mut path) = told.path.clone() else {
        return;
    };
    if read.path.is_empty() {
        // `port.new` is not a field; it is true if a message has arrived
        path.steps.pop();
    }
    if let Some((schema, at)) = field(scene, &path, face, report)
        && !read.applies_to(&schema)
    {
        let reason = format!("`{}` cannot test `{path}`", told.text.value);
        condition(reason, &schema, told.text.span, at, report);
    }
}

fn condition(
    reason: String,
    schema: &Schema,
    at: Span,
    declared: Option<Span>,
    report: &mut Report,
) {
    report.found(InvalidCondition {
        reason,
        found: format!("has type `{schema}`"),
        help: CONDITION_HELP,
        at,
        declared,
    });
}

/// Resolves `port.field` to the shape of the field and the source location of the message type; reports an unknown port
/// or field.
fn field(
    scene: &CheckedComposite<'_>,
    path: &MessagePath,
    face: &Endpoints,
    report: &mut Report,
) -> Option<(Schema, Option<Span>)> {
    let (port, steps) = path.steps.split_first()?;
    let Some((_, found)) = face.port(port, PortDirection::In) else {
        report.found(unknown("port", port, face.nearest_port(port)));
        return None;
    };
    let kind = found.kind.as_ref()?;
    match scene.types.steps(&kind.text, steps) {
        Ok(schema) => Some((schema?, scene.types.declared(&kind.text))),
        Err(error) => {
            report.found(error);
            None
        }
    }
}

/// Returns whether the schema is numeric, as required for a tolerance.
fn is_number(schema: &Schema) -> bool {
    if let Shape::List(element) | Shape::Array(element, _) = &schema.shape {
        return is_number(element);
    }
    schema.shape == Shape::Any || schema.shape.is_number()
}
