//! Checks the port mappings of the built-in components port-proxy and ros-bridge.

use crate::codes::c004::MissingKey;
use crate::codes::c122::PortNotListed;
use crate::codes::c123::PortTypeDiffers;
use asmotion_diagnostics::Report;

use super::component::unknown;
use super::endpoints::{Endpoints, TypeAt};
use super::proxy;
use super::scene::CheckedComposite;
use crate::at::At;
use crate::finding::Findings;
use crate::model::{BuiltinComponent, Component, Direction, Implementation, MapEntry, RosEntry};
use crate::nearest::nearest;

pub(crate) fn check(scene: &mut CheckedComposite<'_>, report: &mut Report) {
    let mut faces: Vec<(usize, Endpoints)> = Vec::new();
    for (index, part) in scene.parts.iter().enumerate() {
        let component = part.component;
        let Some(made_of @ Implementation::Builtin { target, bridge, .. }) =
            &component.implementation
        else {
            continue;
        };
        let Some(kind) = made_of.builtin() else {
            continue;
        };
        match kind {
            BuiltinComponent::PortProxy => {
                let target = target.as_ref();
                if let Some(face) = proxy::check(scene, component, target, &part.face, report) {
                    faces.push((index, face));
                }
            }
            BuiltinComponent::Remote => {
                if target.is_none() {
                    let example = "\"robot://arm/Driver\"";
                    missing(
                        component,
                        "target",
                        example,
                        "a component of another robot",
                        report,
                    );
                }
            }
            BuiltinComponent::RosBridge => ros_bridge(scene, component, bridge.as_ref(), report),
            BuiltinComponent::WebMonitor
            | BuiltinComponent::Recorder
            | BuiltinComponent::Replayer
            | BuiltinComponent::Simulator
            | BuiltinComponent::HttpGateway
            | BuiltinComponent::Timer => {}
        }
    }
    for (index, face) in faces {
        if let Some(part) = scene.parts.get_mut(index) {
            part.face = face;
        }
    }
}

fn ros_bridge(
    scene: &CheckedComposite<'_>,
    component: &Component,
    bridge: Option<&At<String>>,
    report: &mut Report,
) {
    let bridges = &scene.composite.bridges;
    match bridge {
        None => missing(component, "bridge", "\"ros\"", "a ros-bridge", report),
        Some(name) if !bridges.iter().any(|bridge| bridge.name.value == name.value) => {
            let known = bridges
                .iter()
                .map(|it| (it.name.value.as_str(), Some(it.name.span)));
            report.found(unknown("bridge", name, nearest(name, known)));
        }
        Some(_) => {}
    }
    for entry in &component.special.map {
        if let MapEntry::Ros(entry) = entry {
            ros_entry(scene, component, entry, report);
        }
    }
}

fn ros_entry(
    scene: &CheckedComposite<'_>,
    component: &Component,
    entry: &RosEntry,
    report: &mut Report,
) {
    let (list, key, direction) = match entry.direction.value {
        Direction::ToRos => (&component.subscribe, "subscribe", "to ROS"),
        Direction::FromRos => (&component.publish, "publish", "from ROS"),
    };
    match list
        .iter()
        .find(|listed| listed.name.value == entry.from.value)
    {
        None => report.found(PortNotListed {
            name: entry.from.value.clone(),
            direction,
            list: key,
            kind: entry.kind.value.clone(),
            at: entry.from.span,
        }),
        Some(listed) if entry.convert.is_none() && !scene.types.same(&listed.kind, &entry.kind) => {
            report.found(PortTypeDiffers {
                name: entry.from.value.clone(),
                here: listed.kind.value.clone(),
                there: entry.kind.value.clone(),
                at: entry.kind.span,
                declared: TypeAt::new(&listed.kind.value, Some(listed.kind.span))
                    .and_then(|kind| kind.at),
            });
        }
        Some(_) => {}
    }
}

/// Reports a missing key of a built-in component.
pub(super) fn missing(
    component: &Component,
    key: &'static str,
    example: &str,
    of: &'static str,
    report: &mut Report,
) {
    let at = component
        .implementation
        .as_ref()
        .map_or(component.name.span, Implementation::span);
    report.found(MissingKey {
        key,
        of,
        at,
        example: example.to_owned(),
    });
}
