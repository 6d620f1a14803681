//! Checks brokers and bridges.

use crate::codes::c004::MissingKey;
use crate::codes::c076::UnsupportedKey;
use asmotion_diagnostics::Report;

use super::scene::CheckedComposite;
use crate::finding::Findings;
use crate::model::{Bridge, BridgeKind};

pub(crate) fn check(scene: &CheckedComposite<'_>, report: &mut Report) {
    for bridge in &scene.composite.bridges {
        report.found(UnsupportedKey {
            key: "bridges",
            at: bridge.name.span,
            instead: "connect to ROS with a program of its own on the broker (docs/wire.md)",
        });
        let missing = match bridge.kind.value {
            BridgeKind::Ros1 if bridge.master.is_none() => {
                Some(("master", "\"http://127.0.0.1:11311\""))
            }
            BridgeKind::Rosbridge if bridge.url.is_none() => {
                Some(("url", "\"ws://127.0.0.1:9090\""))
            }
            BridgeKind::Ros1 | BridgeKind::Ros2 | BridgeKind::Rosbridge => None,
        };
        if let Some((key, example)) = missing {
            report.found(MissingKey {
                key,
                of: of(bridge),
                at: bridge.name.span,
                example: example.to_owned(),
            });
        }
    }
}

fn of(bridge: &Bridge) -> &'static str {
    match bridge.kind.value {
        BridgeKind::Ros1 => "a bridge to ROS 1",
        BridgeKind::Ros2 => "a bridge to ROS 2",
        BridgeKind::Rosbridge => "a bridge to rosbridge",
    }
}
