//! Checks the operations that a ros-bridge joins with services and actions of ROS.

use std::borrow::Cow;

use std::collections::BTreeMap;

use asmotion_bridge::{Conversion, Use};
use asmotion_component::declaration::OperationDeclaration;
use asmotion_datum::{Schema, Shape};
use asmotion_diagnostics::{Report, Span};

use super::component::unknown;
use super::ros_bridge::{definition, generation, operation_of};
use super::scene::CheckedComposite;
use crate::at::At;
use crate::catalogue::RosOperation;
use crate::codes::c048::IdleKey;
use crate::codes::c076::UnsupportedKey;
use crate::codes::c122::PortNotListed;
use crate::codes::c180::UnknownRosOperation;
use crate::codes::c181::RosOperationDiffers;
use crate::codes::c182::OperationNotMapped;
use crate::codes::c183::OperationMappedTwice;
use crate::finding::Findings;
use crate::model::{Bridge, Component, Direction, Listed, MapEntry, RosEntry};
use crate::nearest::{nearest, nearest_name};

/// Checks an entry that maps an operation.
pub(super) fn check_entry(
    scene: &CheckedComposite<'_>,
    component: &Component,
    bridge: &Bridge,
    entry: &RosEntry,
    report: &mut Report,
) {
    let keys = [
        ("qos", entry.qos.is_some()),
        ("convert", !entry.convert.is_empty()),
        ("transform", entry.transform.is_some()),
    ];
    for (key, _) in keys.into_iter().filter(|(_, is_given)| *is_given) {
        report.found(IdleKey {
            key: Cow::Borrowed(key),
            at: entry.span,
            reason: "belongs to topics",
        });
    }
    // reported at the bridge
    let Some(messages) = scene.ros(bridge) else {
        return;
    };
    let Some(operations) = messages.operations() else {
        report.found(UnsupportedKey {
            key: "map",
            at: entry.from.span,
            instead: "this bridge connects topics: join services with a program of its own".into(),
        });
        return;
    };
    let Some(there) = operations.find(&entry.kind) else {
        if scene.member.has_wrong_ros(&bridge.name) {
            return;
        }
        let known = operations.names();
        report.found(UnknownRosOperation {
            name: entry.kind.value.clone(),
            generation: generation(bridge.kind.value),
            at: entry.kind.span,
            problem: messages.problem(&entry.kind),
            nearest: nearest_name(&entry.kind, known.iter().map(String::as_str)),
        });
        return;
    };
    if there.feedback.is_none() {
        only_for_actions(entry, "a service gives no feedback and has no goal", report);
    }
    if let (Some(cancel), Direction::FromRos, Some(_)) =
        (&entry.cancel, entry.direction.value, &there.feedback)
    {
        report.found(IdleKey {
            key: Cow::Borrowed("cancel"),
            at: cancel.span,
            reason: "clients in ROS cancel their goals themselves",
        });
    }
    if let (Some(result), Direction::FromRos, Some(_)) =
        (&entry.result, entry.direction.value, &there.feedback)
    {
        report.found(IdleKey {
            key: Cow::Borrowed("result"),
            at: result.span,
            reason: "a fault of the reference has no result",
        });
    }
    if let (Some(port), Some(schema)) = (&entry.feedback, &there.feedback) {
        let what = ("feedback", schema);
        check_feedback(scene, component, entry, port, (what, &there), report);
    }
    if let (Some(port), Direction::ToRos, Some(_)) =
        (&entry.result, entry.direction.value, &there.feedback)
    {
        let what = ("result", &there.response);
        check_feedback(scene, component, entry, port, (what, &there), report);
    }
    let Some(interface) = interface(component, entry, report) else {
        return;
    };
    let Some(known) = scene.catalogue.operations(interface) else {
        return;
    };
    check_operation(&known, entry, &there, report);
}

/// Reports keys of actions.
pub(super) fn only_for_actions(entry: &RosEntry, reason: &'static str, report: &mut Report) {
    let keys = [
        ("feedback", &entry.feedback),
        ("result", &entry.result),
        ("cancel", &entry.cancel),
    ];
    for (key, written) in keys {
        if let Some(written) = written {
            let at = written.span;
            report.found(IdleKey {
                key: Cow::Borrowed(key),
                at,
                reason,
            });
        }
    }
}

/// Checks that every operation of the services of a bridge is mapped once, and every service of ROS is offered once.
pub(super) fn check_all(scene: &CheckedComposite<'_>, component: &Component, report: &mut Report) {
    let mut taken: BTreeMap<(&str, bool), Span> = BTreeMap::new();
    let mut mapped: BTreeMap<&str, Span> = BTreeMap::new();
    for entry in &component.special.map {
        let MapEntry::Ros(entry) = entry else {
            continue;
        };
        if operation_of(entry).is_none() {
            continue;
        }
        let offered = entry.direction.value == Direction::FromRos;
        let once = offered.then_some(&entry.ros);
        for name in [Some(&entry.from), once].into_iter().flatten() {
            let key = (name.value.as_str(), offered);
            if let Some(before) = taken.insert(key, name.span) {
                report.found(OperationMappedTwice {
                    name: name.value.clone(),
                    at: name.span,
                    before,
                });
            }
        }
        if !offered {
            let names = [Some(&entry.from), entry.cancel.as_ref()];
            let names = names.into_iter().flatten();
            mapped.extend(names.map(|name| (name.value.as_str(), name.span)));
        }
    }
    for Listed { name, kind } in &component.services {
        for operation in scene.catalogue.operations(kind).unwrap_or_default() {
            let operation = format!("{}.{}", name.value, operation.name);
            if !mapped.contains_key(&*operation) {
                let at = name.span;
                report.found(OperationNotMapped { operation, at });
            }
        }
    }
}

/// The interface of the service or reference that an entry names; reports one that is not listed.
fn interface<'c>(
    component: &'c Component,
    entry: &RosEntry,
    report: &mut Report,
) -> Option<&'c str> {
    let (port, _) = operation_of(entry)?;
    let found = match entry.direction.value {
        Direction::ToRos => {
            let mut services = component.services.iter();
            let service = services.find(|it| it.name.value == port);
            service.map(|it| it.kind.value.as_str())
        }
        Direction::FromRos => {
            let mut references = component.references.iter();
            let reference = references.find(|it| it.name.value == port);
            reference.map(|it| it.interface.value.as_str())
        }
    };
    if found.is_none() {
        let (direction, list) = match entry.direction.value {
            Direction::ToRos => ("to ROS", "services"),
            Direction::FromRos => ("from ROS", "references"),
        };
        report.found(PortNotListed {
            name: port.to_owned(),
            direction,
            list,
            kind: entry.kind.value.clone(),
            at: entry.from.span,
        });
    }
    found
}

/// Compares the types of an operation with those in ROS.
fn check_operation(
    known: &[OperationDeclaration],
    entry: &RosEntry,
    there: &RosOperation,
    report: &mut Report,
) {
    let find = |name: &str| known.iter().find(|known| known.name == name);
    let Some((port, name)) = operation_of(entry) else {
        return;
    };
    let known_names = known.iter();
    let known_names: Vec<String> = known_names
        .map(|known| format!("{port}.{}", known.name))
        .collect();
    let unknown = |written: &At<String>| {
        let names = known_names.iter().map(|known| (known.as_str(), None));
        unknown("operation", written, nearest(written, names))
    };
    if let Some(cancel) = &entry.cancel {
        let of_service = cancel.value.split_once('.');
        let of_service = of_service.filter(|(service, _)| *service == port);
        if of_service.and_then(|(_, name)| find(name)).is_none() {
            report.found(unknown(cancel));
        }
    }
    let Some(here) = find(name) else {
        report.found(unknown(&entry.from));
        return;
    };
    let converts = |from, to, usage| Conversion::between(from, to, usage).is_some();
    let (request, response) = match entry.direction.value {
        Direction::ToRos => (
            converts(&here.request, &there.request, Use::All)
                && !is_made_up(&here.request, &there.request),
            converts(&there.response, &here.response, Use::Fill),
        ),
        Direction::FromRos => (
            converts(&there.request, &here.request, Use::Fill),
            converts(&here.response, &there.response, Use::All)
                && !is_made_up(&here.response, &there.response),
        ),
    };
    for (part, fits) in [("request", request), ("response", response)] {
        if !fits {
            report.found(RosOperationDiffers {
                part,
                operation: entry.from.value.clone(),
                there: entry.kind.value.clone(),
                at: entry.kind.span,
                definition_here: format!(
                    "{}---\n{}",
                    lines(definition(&here.request)),
                    definition(&here.response)
                ),
                definition_there: there.definition.clone(),
            });
        }
    }
}

/// Returns whether all of a message would be made up, because there are no data for it.
fn is_made_up(from: &Schema, to: &Schema) -> bool {
    let is_empty =
        |schema: &Schema| matches!(&schema.shape, Shape::Record(fields) if fields.is_empty());
    is_empty(from) && !is_empty(to)
}

fn check_feedback(
    scene: &CheckedComposite<'_>,
    component: &Component,
    entry: &RosEntry,
    port: &At<String>,
    ((part, there), of): ((&'static str, &Schema), &RosOperation),
    report: &mut Report,
) {
    let (lists, list, direction) = match entry.direction.value {
        Direction::ToRos => {
            let lists = [&component.publish, &component.ports.outputs];
            (lists, "publish", "from ROS")
        }
        Direction::FromRos => {
            let lists = [&component.subscribe, &component.ports.inputs];
            (lists, "subscribe", "to ROS")
        }
    };
    let mut listed = lists.into_iter().flatten();
    let Some(listed) = listed.find(|listed| listed.name.value == port.value) else {
        report.found(PortNotListed {
            name: port.value.clone(),
            direction,
            list,
            kind: there.name.clone().into_owned(),
            at: port.span,
        });
        return;
    };
    // an unknown type is reported where it is listed
    let Some(here) = scene.types.schema(&listed.kind) else {
        return;
    };
    let conversion = match entry.direction.value {
        Direction::ToRos => Conversion::between(there, &here, Use::Fill),
        Direction::FromRos => Conversion::between(&here, there, Use::All),
    };
    if conversion.is_none() {
        report.found(RosOperationDiffers {
            part,
            operation: entry.from.value.clone(),
            there: entry.kind.value.clone(),
            at: port.span,
            definition_here: definition(&here),
            definition_there: of.definition.clone(),
        });
    }
}

/// A definition whose last line ends, also that of a type without a name.
fn lines(definition: String) -> String {
    if definition.is_empty() || definition.ends_with('\n') {
        return definition;
    }
    format!("{definition}\n")
}
