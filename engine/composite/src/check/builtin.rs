//! Checks the built-in components.

use crate::codes::c004::MissingKey;
use asmotion_diagnostics::Report;

use super::endpoints::Endpoints;
use super::scene::CheckedComposite;
use super::{proxy, ros_bridge};
use crate::finding::Findings;
use crate::model::{BuiltinComponent, Component, Implementation};

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
            BuiltinComponent::RosBridge => {
                ros_bridge::check(scene, component, bridge.as_ref(), report)
            }
            BuiltinComponent::WebMonitor
            | BuiltinComponent::Recorder
            | BuiltinComponent::Replayer
            | BuiltinComponent::Simulator
            | BuiltinComponent::HttpGateway
            | BuiltinComponent::Timer => {}
        }
    }
    for (index, face) in faces {
        if let Some(part) = scene.parts.at_mut(index) {
            part.face = face;
        }
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
