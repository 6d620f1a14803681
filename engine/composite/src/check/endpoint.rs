//! Checks bridges.

use std::borrow::Cow;

use crate::codes::c004::MissingKey;
use crate::codes::c048::IdleKey;
use crate::codes::c076::UnsupportedKey;
use crate::codes::c171::UnusedBridge;
use asmotion_diagnostics::{Report, Span};

use super::ros_bridge::check_name;
use super::scene::CheckedComposite;
use crate::finding::Findings;
use crate::model::{Bridge, BridgeKind, Component, Implementation, MapEntry};

/// Topic of transforms of a bridge that names none.
const TRANSFORMS: &str = "/tf";

pub(crate) fn check(scene: &CheckedComposite<'_>, report: &mut Report) {
    for bridge in &scene.composite.bridges {
        let kind = bridge.kind.value;
        if scene.ros(bridge).is_none() {
            let way = scene.catalogue.way_to_bridges(kind);
            let own = "connect to ROS with a program of its own on the broker (docs/wire.md)";
            report.found(UnsupportedKey {
                key: "bridges",
                at: bridge.name.span,
                instead: way.map_or(own.into(), Into::into),
            });
        }
        if !is_used(scene, bridge) {
            report.found(UnusedBridge {
                name: bridge.name.value.clone(),
                at: bridge.name.span,
            });
        }
        if let Some(node) = &bridge.node {
            check_name(node, kind, report);
        }
        if let Some(topic) = &bridge.transforms {
            check_name(topic, kind, report);
            // an expansion has the default
            if topic.value != TRANSFORMS && !has_transforms(scene, bridge) {
                report.found(IdleKey {
                    key: Cow::Borrowed("transforms"),
                    at: topic.span,
                    reason: "no mapping of the bridge has the key `transform`",
                });
            }
        }
        if let (BridgeKind::Rosbridge, Some(folder)) = (kind, bridge.definitions.first()) {
            report.found(IdleKey {
                key: Cow::Borrowed("definitions"),
                at: folder.span,
                reason: "belongs to bridges of another kind",
            });
        }
        check_keys(bridge, report);
    }
}

/// Reports a missing key, and keys of bridges of another kind.
fn check_keys(bridge: &Bridge, report: &mut Report) {
    let example = match bridge.kind.value {
        BridgeKind::Ros1 => Some(("master", "\"http://127.0.0.1:11311\"")),
        BridgeKind::Ros2 => None,
        BridgeKind::Rosbridge => Some(("url", "\"ws://127.0.0.1:9090\"")),
    };
    let keys: [(&'static str, Option<Span>, BridgeKind); 3] = [
        (
            "master",
            bridge.master.as_ref().map(|it| it.span),
            BridgeKind::Ros1,
        ),
        (
            "domain",
            bridge.domain.as_ref().map(|it| it.span),
            BridgeKind::Ros2,
        ),
        (
            "url",
            bridge.url.as_ref().map(|it| it.span),
            BridgeKind::Rosbridge,
        ),
    ];
    for (key, at, kind) in keys {
        match at {
            None => {
                if let Some((_, example)) = example.filter(|(required, _)| *required == key) {
                    report.found(MissingKey {
                        key,
                        of: of(bridge),
                        at: bridge.name.span,
                        example: example.to_owned(),
                    });
                }
            }
            Some(at) if kind != bridge.kind.value => report.found(IdleKey {
                key: Cow::Borrowed(key),
                at,
                reason: "belongs to bridges of another kind",
            }),
            Some(_) => {}
        }
    }
}

/// Returns whether a component of the composite names a bridge, in any profile.
fn is_used(scene: &CheckedComposite<'_>, bridge: &Bridge) -> bool {
    users(scene, bridge).next().is_some()
}

/// Returns whether a component that names a bridge transforms messages, in any profile.
fn has_transforms(scene: &CheckedComposite<'_>, bridge: &Bridge) -> bool {
    let mut entries = users(scene, bridge).flat_map(|it| &it.special.map);
    entries.any(|entry| matches!(entry, MapEntry::Ros(entry) if entry.transform.is_some()))
}

/// The components of the composite that name a bridge, in any profile.
fn users<'s>(
    scene: &'s CheckedComposite<'_>,
    bridge: &'s Bridge,
) -> impl Iterator<Item = &'s Component> {
    let components = scene.composite.components.iter();
    components.filter(|component| {
        let Some(Implementation::Builtin {
            bridge: Some(name), ..
        }) = &component.implementation
        else {
            return false;
        };
        name.value == bridge.name.value
    })
}

fn of(bridge: &Bridge) -> &'static str {
    match bridge.kind.value {
        BridgeKind::Ros1 => "a bridge to ROS 1",
        BridgeKind::Ros2 => "a bridge to ROS 2",
        BridgeKind::Rosbridge => "a bridge to rosbridge",
    }
}
