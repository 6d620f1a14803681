//! Checks the deployment: every component must run in exactly one process.

use crate::codes::c048::IdleKey;
use crate::codes::c070::PlacedTwice;
use crate::codes::c071::PlacedNowhere;
use crate::codes::c072::DuplicateProcess;
use crate::codes::c073::UnknownRecordedTopic;
use std::collections::BTreeMap;

use asmotion_diagnostics::{Report, Span};

use super::scene::CheckedComposite;
use super::topic::Topics;
use crate::finding::Findings;
use crate::model::{Deploy, Process, RestartPolicy};
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
        report.found(IdleKey { key, at, reason });
    }
}

fn place<'s>(
    scene: &CheckedComposite<'_>,
    process: &'s Process,
    places: &mut BTreeMap<&'s str, Span>,
    report: &mut Report,
) {
    for name in &process.components {
        if scene.composite.component(name).is_none() {
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
