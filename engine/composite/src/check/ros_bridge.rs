//! Checks the built-in component ros-bridge.

use std::borrow::Cow;

use std::collections::BTreeMap;

use asmotion_bridge::FieldConverter;
use asmotion_datum::{Schema, Shape};
use asmotion_diagnostics::Report;
use asmotion_transform::MessageTransform;

use super::builtin::missing;
use super::component::unknown;
use super::endpoints::TypeAt;
use super::scene::CheckedComposite;
use super::{ros_component, ros_operation};
use crate::at::At;
use crate::codes::c048::IdleKey;
use crate::codes::c122::PortNotListed;
use crate::codes::c123::{PortTypeDiffers, RosDifference};
use crate::codes::c170::UnknownRosType;
use crate::codes::c172::MappedTwice;
use crate::codes::c173::InvalidRosName;
use crate::codes::c174::NoTransformation;
use crate::codes::c184::WrongConverter;
use crate::finding::Findings;
use crate::model::{Bridge, BridgeKind, Component, Direction, Listed, MapEntry, RosEntry};
use crate::nearest::{nearest, nearest_name};
use crate::table::NamedValue;

pub(super) fn check(
    scene: &CheckedComposite<'_>,
    component: &Component,
    bridge: Option<&At<String>>,
    report: &mut Report,
) {
    let bridges = &scene.composite.bridges;
    let Some(name) = bridge else {
        missing(component, "bridge", "\"ros\"", "a ros-bridge", report);
        return;
    };
    let Some(bridge) = bridges.iter().find(|it| it.name.value == name.value) else {
        let known = bridges
            .iter()
            .map(|it| (it.name.value.as_str(), Some(it.name.span)));
        report.found(unknown("bridge", name, nearest(name, known)));
        return;
    };
    let mut published: BTreeMap<&str, &RosEntry> = BTreeMap::new();
    for entry in &component.special.map {
        let MapEntry::Ros(entry) = entry else {
            continue;
        };
        check_name(&entry.ros, bridge.kind.value, report);
        if operation_of(entry).is_some() {
            ros_operation::check_entry(scene, component, bridge, entry, report);
            continue;
        }
        ros_operation::only_for_actions(entry, "belongs to actions", report);
        check_qos(entry, bridge.kind.value, report);
        check_transform(entry, report);
        check_entry(scene, component, bridge, entry, report);
        if entry.direction.value == Direction::ToRos
            && let Some(first) = published.insert(&entry.ros, entry)
        {
            report.found(MappedTwice {
                ros: entry.ros.value.clone(),
                first: first.from.value.clone(),
                second: entry.from.value.clone(),
                at: entry.ros.span,
                before: first.ros.span,
            });
        }
    }
    ros_operation::check_all(scene, component, report);
    ros_component::check(scene, component, bridge.kind.value, report);
}

/// The service or reference, and the operation, that an entry names in place of a port.
pub(super) fn operation_of(entry: &RosEntry) -> Option<(&str, &str)> {
    entry.from.value.split_once('.')
}

fn check_entry(
    scene: &CheckedComposite<'_>,
    component: &Component,
    bridge: &Bridge,
    entry: &RosEntry,
    report: &mut Report,
) {
    let (lists, key, direction) = match entry.direction.value {
        Direction::ToRos => {
            let lists = [&component.subscribe, &component.ports.inputs];
            (lists, "subscribe", "to ROS")
        }
        Direction::FromRos => {
            let lists = [&component.publish, &component.ports.outputs];
            (lists, "publish", "from ROS")
        }
    };
    let mut listed = lists.into_iter().flatten();
    match listed.find(|listed| listed.name.value == entry.from.value) {
        None => report.found(PortNotListed {
            name: entry.from.value.clone(),
            direction,
            list: key,
            kind: entry.kind.value.clone(),
            at: entry.from.span,
        }),
        Some(listed) => check_types(scene, bridge, entry, listed, report),
    }
}

/// Reports policies without effect: ROS 1 has depth and durability only, and messages expire where they are sent.
fn check_qos(entry: &RosEntry, kind: BridgeKind, report: &mut Report) {
    let Some(qos) = &entry.qos else {
        return;
    };
    let reliability = qos.reliability.as_ref().map(|it| it.span);
    let deadline = qos.deadline_ms.as_ref().map(|it| it.span);
    let lifespan = qos.lifespan_ms.as_ref().map(|it| it.span);
    let policies = [
        ("reliability", reliability),
        ("deadline_ms", deadline),
        ("lifespan_ms", lifespan),
    ];
    for (key, at) in policies {
        let reason = match (kind, entry.direction.value) {
            (BridgeKind::Ros1 | BridgeKind::Rosbridge, _) => "only ROS 2 has this policy",
            (BridgeKind::Ros2, Direction::FromRos) if key == "lifespan_ms" => {
                "the publisher in ROS decides when its messages expire"
            }
            (BridgeKind::Ros2, Direction::ToRos | Direction::FromRos) => continue,
        };
        if let Some(at) = at {
            report.found(IdleKey {
                key: Cow::Borrowed(key),
                at,
                reason,
            });
        }
    }
}

/// Checks that the messages of an entry can be transformed into its frame.
fn check_transform(entry: &RosEntry, report: &mut Report) {
    let Some(transform) = &entry.transform else {
        return;
    };
    if let Err(reason) = MessageTransform::new(&entry.kind, &transform.frame) {
        report.found(NoTransformation {
            reason,
            at: transform.frame.span,
        });
    }
}

/// Compares the type of a port with that of its topic in ROS.
fn check_types(
    scene: &CheckedComposite<'_>,
    bridge: &Bridge,
    entry: &RosEntry,
    listed: &Listed,
    report: &mut Report,
) {
    // reported at the bridge; there are no definitions
    let Some(messages) = scene.ros(bridge) else {
        return;
    };
    let Some(there) = messages.find(&entry.kind) else {
        if scene.member.has_wrong_ros(&bridge.name) {
            return;
        }
        let known = messages.names();
        report.found(UnknownRosType {
            name: entry.kind.value.clone(),
            generation: generation(bridge.kind.value),
            at: entry.kind.span,
            problem: messages.problem(&entry.kind),
            nearest: nearest_name(&entry.kind, known.iter().map(String::as_str)),
        });
        return;
    };
    // an unknown type is reported where it is listed
    let Some(here) = scene.types.schema(&listed.kind) else {
        return;
    };
    let here = converted(entry, here, &there.schema, report);
    let Err(difference) = here.compare(&there.schema) else {
        return;
    };
    report.found(PortTypeDiffers {
        name: entry.from.value.clone(),
        here: listed.kind.value.clone(),
        there: entry.kind.value.clone(),
        at: entry.kind.span,
        declared: TypeAt::new(&listed.kind.value, Some(listed.kind.span)).and_then(|kind| kind.at),
        definitions: Some(RosDifference {
            difference: difference.to_string(),
            here: definition(&here),
            there: there.definition,
        }),
    });
}

/// Checks the converters of an entry. Returns the schema of the port with the types that the converted fields have in ROS.
fn converted(entry: &RosEntry, here: Schema, there: &Schema, report: &mut Report) -> Schema {
    let mut converted = here;
    for NamedValue { name, value } in &entry.convert {
        let converter = FieldConverter::parse(name, value);
        let checked = converter.and_then(|it| it.check(&converted, there).map(|()| it));
        match checked {
            Ok(converter) => converted = converter.converted(converted, there),
            Err(reason) => report.found(WrongConverter {
                reason,
                at: value.span,
            }),
        }
    }
    converted
}

/// A schema in the form of a definition of ROS.
pub(super) fn definition(schema: &Schema) -> String {
    let Shape::Record(fields) = &schema.shape else {
        return schema.to_string();
    };
    let lines = fields.iter();
    let lines = lines.map(|field| format!("{} {}\n", field.schema, field.name));
    lines.collect()
}

/// Reports a text that is not a name in ROS of this generation.
pub(super) fn check_name(name: &At<String>, kind: BridgeKind, report: &mut Report) {
    // a name of ROS 2 becomes one of DDS, where two underscores are a separator
    let is_separated = kind == BridgeKind::Ros2 && name.contains("__");
    if !is_name(name) || is_separated {
        report.found(InvalidRosName {
            name: name.value.clone(),
            at: name.span,
        });
    }
}

fn is_name(name: &str) -> bool {
    let parts = name.strip_prefix('/').unwrap_or(name).split('/');
    parts.into_iter().all(|part| {
        let mut letters = part.chars();
        letters
            .next()
            .is_some_and(|first| first.is_ascii_alphabetic() || first == '_')
            && letters.all(|next| next.is_ascii_alphanumeric() || next == '_')
    })
}

/// The generation of ROS that a bridge connects to, for display.
pub(super) fn generation(kind: BridgeKind) -> &'static str {
    match kind {
        BridgeKind::Ros1 => "ROS 1",
        BridgeKind::Ros2 => "ROS 2",
        BridgeKind::Rosbridge => "rosbridge",
    }
}
