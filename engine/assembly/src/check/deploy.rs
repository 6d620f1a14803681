//! Deployment: every component runs in exactly one process.

use std::collections::BTreeMap;

use asmotion_diagnostics::{Diagnostic, Report, Span};

use super::scene::Scene;
use super::topic::Topics;
use crate::finding::{Finding, Findings};
use crate::model::{Deploy, Process};
use crate::nearest::{Nearest, Suggest, nearest_name};

#[derive(Debug, thiserror::Error)]
pub(crate) enum DeployError {
    #[error("`{component}` is placed twice")]
    Twice {
        component: String,
        at: Span,
        first: Span,
    },
    #[error("`{component}` is placed in no process")]
    Nowhere {
        component: String,
        at: Span,
        deploy: Span,
    },
    #[error("two processes are called `{name}`")]
    SameName { name: String, at: Span, first: Span },
    #[error("no topic matches `{topic}`, so nothing is recorded of it")]
    NoTopic {
        topic: String,
        at: Span,
        nearest: Option<Nearest>,
    },
    #[error("`record` is written, and this build does nothing with it")]
    Idle { at: Span },
}

impl Finding for DeployError {
    fn diagnostic(&self) -> Diagnostic {
        match self {
            Self::Twice { at, first, .. } => Diagnostic::error("C070", self)
                .label(*at, "again here")
                .label(*first, "first here")
                .help("a component runs in one process"),
            Self::Nowhere {
                component,
                at,
                deploy,
            } => Diagnostic::error("C071", self)
                .label(*at, "declared here")
                .label(*deploy, format!("no process has `{component}`"))
                .help("add it to the `components` of a process"),
            Self::SameName { at, first, .. } => Diagnostic::error("C072", self)
                .label(*at, "again here")
                .label(*first, "first here")
                .help("rename one of them, or list all components in one"),
            Self::NoTopic { at, nearest, .. } => Diagnostic::warning("C073", self)
                .label(*at, "no such topic")
                .suggest(*at, nearest),
            Self::Idle { at } => Diagnostic::warning("C076", self)
                .label(*at, "without effect")
                .help("`asmotion run --record FILE --ports NAME` writes down what ports and topics had"),
        }
    }
}

pub(crate) fn check(scene: &Scene<'_>, topics: &Topics, report: &mut Report) {
    let Some(deploy) = &scene.composite.deploy else {
        return;
    };
    let mut names: BTreeMap<&str, Span> = BTreeMap::new();
    let mut places: BTreeMap<&str, Span> = BTreeMap::new();
    for process in &deploy.processes {
        if let Some(first) = names.insert(&process.name, process.name.span) {
            let (name, at) = (process.name.value.clone(), process.name.span);
            report.found(DeployError::SameName { name, at, first });
        }
        place(scene, process, &mut places, report);
    }
    for component in &scene.composite.components {
        if !places.contains_key(component.name.value.as_str()) {
            report.found(DeployError::Nowhere {
                component: component.name.value.clone(),
                at: component.name.span,
                deploy: deploy.span,
            });
        }
    }
    record(deploy, topics, report);
}

fn place<'s>(
    scene: &Scene<'_>,
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
            report.found(DeployError::Twice {
                component,
                at,
                first,
            });
        }
    }
}

fn record(deploy: &Deploy, topics: &Topics, report: &mut Report) {
    if let Some(record) = &deploy.record {
        report.found(DeployError::Idle { at: record.span });
    }
    let recorded = deploy.record.iter().flat_map(|record| &record.topics);
    for topic in recorded.filter(|topic| !topic.contains('*')) {
        if !topics.contains_key(&topic.value) {
            report.found(DeployError::NoTopic {
                topic: topic.value.clone(),
                at: topic.span,
                nearest: nearest_name(topic, topics.keys().map(String::as_str)),
            });
        }
    }
}
