//! Checks the components that a ros-bridge shows to ROS.

use std::borrow::Cow;

use std::collections::BTreeMap;

use asmotion_diagnostics::{Report, Span};

use super::component::unknown;
use super::ros_bridge::check_name;
use super::scene::{CheckedComposite, nested};
use crate::at::At;
use crate::codes::c048::IdleKey;
use crate::codes::c186::{HiddenComponent, HiddenReason};
use crate::finding::Findings;
use crate::model::{BridgeKind, Component};
use crate::nearest::nearest;
use crate::table::NamedValue;

pub(super) fn check(
    scene: &CheckedComposite<'_>,
    component: &Component,
    kind: BridgeKind,
    report: &mut Report,
) {
    let special = &component.special;
    if let (BridgeKind::Ros1 | BridgeKind::Rosbridge, Some(first)) = (kind, special.managed.first())
    {
        report.found(IdleKey {
            key: Cow::Borrowed("managed"),
            at: first.name.span,
            reason: "only ROS 2 has managed nodes",
        });
    }
    let mut taken: BTreeMap<&str, (&str, Span)> = BTreeMap::new();
    let parameters = special.parameters.iter().map(|it| (it, true));
    let managed = special.managed.iter().map(|it| (it, false));
    for (NamedValue { name, value }, has_properties) in parameters.chain(managed) {
        check_name(value, kind, report);
        check_shown(scene, kind, name, has_properties, report);
        let before = taken.insert(&value.value, (&name.value, value.span));
        if let Some((other, at)) = before.filter(|(other, _)| *other != name.value) {
            let other = other.to_owned();
            let reason = HiddenReason::Taken { other, before: at };
            hidden(value, value.span, reason, report);
        }
    }
}

fn hidden(name: &At<String>, at: Span, reason: HiddenReason, report: &mut Report) {
    let name = name.value.clone();
    report.found(HiddenComponent { name, at, reason });
}

/// Checks the component, and the property if there is one.
fn check_shown(
    scene: &CheckedComposite<'_>,
    kind: BridgeKind,
    name: &At<String>,
    has_properties: bool,
    report: &mut Report,
) {
    let (component, property) = match name.split_once('.') {
        Some((component, property)) => (component, Some(property)),
        None => (name.value.as_str(), None),
    };
    let component = At::new(component.to_owned(), name.span);
    let Some(part) = scene.part(&component, report) else {
        return;
    };
    if nested(part.component).is_some() {
        return hidden(name, name.span, HiddenReason::Nested, report);
    }
    let Some(property) = property else {
        return;
    };
    if !has_properties {
        return hidden(name, name.span, HiddenReason::LifeCycleOfProperty, report);
    }
    if kind == BridgeKind::Ros2 {
        return hidden(name, name.span, HiddenReason::PropertyInRos2, report);
    }
    let Some(known) = &part.face.properties else {
        return;
    };
    if !known.iter().any(|it| it.text == property) {
        let known = known.iter();
        let known: Vec<_> = known
            .map(|it| (format!("{}.{}", component.value, it.text), it.at))
            .collect();
        let known = known.iter().map(|(text, at)| (text.as_str(), *at));
        report.found(unknown("property", name, nearest(name, known)));
    }
}
