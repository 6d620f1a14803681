//! Checks the deployment: every component must run in exactly one process.

use std::borrow::Cow;

use crate::codes::c048::IdleKey;
use crate::codes::c070::PlacedTwice;
use crate::codes::c071::PlacedNowhere;
use crate::codes::c072::DuplicateProcess;
use crate::codes::c073::UnknownRecordedTopic;
use std::collections::BTreeMap;

use asmotion_diagnostics::{Report, Span};

use super::scene::{CheckedComposite, nested};
use super::schedule;
use super::topic::Topics;
use crate::family::{Family, Member};
use crate::finding::Findings;
use crate::model::{Component, Deploy, Process, RestartPolicy};
use crate::nearest::nearest_name;

pub(crate) fn check(scene: &CheckedComposite<'_>, topics: &Topics, report: &mut Report) {
    let Some(deploy) = &scene.composite.deploy else {
        return;
    };
    let mut names: BTreeMap<&str, Span> = BTreeMap::new();
    let mut places: BTreeMap<&str, Span> = BTreeMap::new();
    for process in &deploy.processes {
        if let Some(first) = names.insert(&process.name, process.name.span) {
            let (name, at) = (process.name.value.clone(), process.name.span);
            report.found(DuplicateProcess { name, at, first });
        }
        place(scene, process, &mut places, report);
        priority(scene, process, report);
    }
    for component in &scene.composite.components {
        if !places.contains_key(component.name.value.as_str()) {
            report.found(PlacedNowhere {
                component: component.name.value.clone(),
                at: component.name.span,
                deploy: deploy.span,
            });
        }
    }
    record(deploy, topics, report);
    restart(deploy, report);
}

/// Reports limits and delays of restarts where there are none.
fn restart(deploy: &Deploy, report: &mut Report) {
    let Some(restart) = &deploy.restart else {
        return;
    };
    let policy = restart
        .policy
        .as_ref()
        .map_or(RestartPolicy::Never, |it| it.value);
    if policy != RestartPolicy::Never {
        return;
    }
    let max = restart.max.as_ref().map(|it| ("max", it.span));
    let window = restart.window_s.as_ref().map(|it| ("window_s", it.span));
    let backoff = restart.backoff_ms.first().map(|it| ("backoff_ms", it.span));
    for (key, at) in [max, window, backoff].into_iter().flatten() {
        let reason = "nothing is restarted without `policy = \"on_failure\"` or `\"always\"`";
        report.found(IdleKey {
            key: Cow::Borrowed(key),
            at,
            reason,
        });
    }
}

/// Reports the priority of a process in which no thread has a class with priorities and takes this one.
fn priority(scene: &CheckedComposite<'_>, process: &Process, report: &mut Report) {
    let Some(priority) = &process.priority else {
        return;
    };
    let class = process.scheduler.as_ref().map(|it| it.value);
    let is_used = class.is_some_and(schedule::has_priorities)
        || process.components.iter().any(|name| {
            let component = scene.member.component(name);
            component.is_some_and(|it| takes_priority(scene.family, scene.member, it))
        });
    if !is_used {
        report.found(IdleKey {
            key: Cow::Borrowed("priority"),
            at: priority.span,
            reason: schedule::NO_PRIORITIES,
        });
    }
}

/// Returns whether a component, or one within it, has a scheduling class with priorities and takes that of its process.
fn takes_priority(family: &Family, member: &Member, component: &Component) -> bool {
    if let Some(file) = nested(component) {
        return family.nested(member, file).is_some_and(|(_, member)| {
            let mut inner = member.composite.components.iter();
            inner.any(|it| takes_priority(family, member, it))
        });
    }
    component.pace().is_some_and(|pace| {
        let class = pace.scheduler.as_ref().map(|it| it.value);
        pace.priority.is_none() && class.is_some_and(schedule::has_priorities)
    })
}

fn place<'s>(
    scene: &CheckedComposite<'_>,
    process: &'s Process,
    places: &mut BTreeMap<&'s str, Span>,
    report: &mut Report,
) {
    for name in &process.components {
        if scene.member.component(name).is_none() {
            scene.unknown_component(name, report);
            continue;
        }
        if let Some(first) = places.insert(name, name.span) {
            let (component, at) = (name.value.clone(), name.span);
            report.found(PlacedTwice {
                component,
                at,
                first,
            });
        }
    }
}

fn record(deploy: &Deploy, topics: &Topics, report: &mut Report) {
    let recorded = deploy.record.iter().flat_map(|record| &record.topics);
    for topic in recorded.filter(|topic| !topic.contains('*')) {
        if !topics.contains_key(&topic.value) {
            report.found(UnknownRecordedTopic {
                topic: topic.value.clone(),
                at: topic.span,
                nearest: nearest_name(topic, topics.keys().map(String::as_str)),
            });
        }
    }
}
