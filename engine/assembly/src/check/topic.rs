//! Topics: one type over all publishers and subscribers, and somebody who publishes.

use std::collections::BTreeMap;

use source::{Diagnostic, Report, Span};

use super::component::topic;
use super::connection::TopicLink;
use super::face::Kind;
use super::scene::Scene;
use super::wire::own_place;
use crate::finding::{Finding, Findings};
use crate::model::{Component, Promoted};
use crate::nearest::{Nearest, Suggest, nearest};

#[derive(Debug, thiserror::Error)]
pub(crate) enum TopicError {
    #[error("topic `{topic}` has two types: `{kind}` and `{other}`")]
    TwoTypes { topic: String, kind: String, other: String, at: Span, other_at: Span },
    #[error("nobody publishes `{topic}`")]
    Silent { topic: String, at: Span, nearest: Option<Nearest> },
    #[error("`{component}` neither subscribes nor publishes `{name}`, so it cannot be renamed")]
    UnknownRename { component: String, name: String, at: Span, known: Vec<(String, Span)> },
}

impl Finding for TopicError {
    fn diagnostic(&self) -> Diagnostic {
        match self {
            Self::TwoTypes { kind, other, at, other_at, .. } => Diagnostic::error("C050", self)
                .label(*at, format!("`{kind}` here"))
                .label(*other_at, format!("`{other}` here"))
                .help("rename one of the two, or use one type"),
            Self::Silent { topic, at, nearest } => {
                let diagnostic = Diagnostic::warning("C051", self)
                    .label(*at, "subscribed here");
                match nearest {
                    Some(_) => diagnostic.suggest(*at, nearest),
                    None => diagnostic.help(format!(
                        "if it comes from outside, write `[[promote]]` with `topic = \"{topic}\"`"
                    )),
                }
            }
            Self::UnknownRename { name, at, known, .. } => {
                let all = known.iter().map(|(name, at)| (name.as_str(), Some(*at)));
                let nearest = nearest(name, all);
                let diagnostic = Diagnostic::error("C052", self).label(*at, "no such topic");
                match nearest {
                    Some(_) => diagnostic.suggest(*at, &nearest),
                    None => diagnostic.help("left is the name in the component, right the topic"),
                }
            }
        }
    }
}

/// The topics of a composite in one profile, by name.
pub(crate) type Topics = BTreeMap<String, Vec<Role>>;

/// Somebody who publishes or subscribes a topic.
pub(crate) struct Role {
    pub at: Span,
    pub kind: Option<Kind>,
    pub published: bool,
    pub subscribed: bool,
}

/// Checks all topics, and returns them.
pub(crate) fn check(scene: &Scene<'_>, links: &[TopicLink], report: &mut Report) -> Topics {
    for part in &scene.parts {
        renames(scene, part.component, report);
    }
    let topics = collect(scene, links);
    let promoted: Vec<&str> = scene
        .composite
        .promotions
        .iter()
        .filter(|promotion| scene.active(&promotion.profiles))
        .filter_map(|promotion| match &promotion.what {
            Promoted::Topic(topic) => Some(topic.value.as_str()),
            _ => None,
        })
        .collect();
    for (topic, roles) in &topics {
        types(topic, roles, report);
        if !promoted.contains(&topic.as_str()) {
            silent(topic, roles, &topics, report);
        }
    }
    topics
}

fn collect(scene: &Scene<'_>, links: &[TopicLink]) -> Topics {
    let mut topics = Topics::new();
    let mut add = |name: &str, role: Role| topics.entry(name.to_owned()).or_default().push(role);
    for part in &scene.parts {
        let ports = part.face.inputs.iter().map(|port| (false, port));
        for (published, port) in ports.chain(part.face.outputs.iter().map(|port| (true, port))) {
            if let Some(topic) = &port.topic {
                let at = own_place(part, port.name.at);
                let kind = port.kind.clone();
                add(topic, Role { at, kind, published, subscribed: !published });
            }
        }
        for promoted in &part.face.topics {
            let name = topic(part.component, &promoted.name.text);
            let (kind, at) = (promoted.kind.clone(), part.component.name.span);
            let (published, subscribed) = (promoted.published, promoted.subscribed);
            add(&name, Role { at, kind, published, subscribed });
        }
    }
    for link in links {
        let (kind, published) = (link.kind.clone(), link.published);
        add(&link.topic, Role { at: link.at, kind, published, subscribed: !published });
    }
    topics
}

fn types(topic: &str, roles: &[Role], report: &mut Report) {
    let mut typed = roles.iter().filter_map(|role| Some((role, role.kind.as_ref()?)));
    let Some((first_role, first)) = typed.next() else {
        return;
    };
    for (role, kind) in typed.filter(|(_, kind)| kind.text != first.text) {
        report.found(TopicError::TwoTypes {
            topic: topic.to_owned(),
            kind: kind.text.clone(),
            other: first.text.clone(),
            at: kind.at.unwrap_or(role.at),
            other_at: first.at.unwrap_or(first_role.at),
        });
    }
}

fn silent(topic: &str, roles: &[Role], topics: &Topics, report: &mut Report) {
    if roles.iter().any(|role| role.published) {
        return;
    }
    let Some(subscriber) = roles.iter().find(|role| role.subscribed) else {
        return;
    };
    let published = topics.iter().filter_map(|(name, roles)| {
        let publisher = roles.iter().find(|role| role.published)?;
        Some((name.as_str(), Some(publisher.at)))
    });
    report.found(TopicError::Silent {
        topic: topic.to_owned(),
        at: subscriber.at,
        nearest: nearest(topic, published),
    });
}

fn renames(scene: &Scene<'_>, component: &Component, report: &mut Report) {
    let part = scene.parts.iter().find(|part| part.component.name.value == component.name.value);
    let Some(face) = part.map(|part| &part.face).filter(|face| !face.blank) else {
        return;
    };
    let listed = component.subscribe.iter().chain(&component.publish);
    let mut known: Vec<(String, Span)> =
        listed.map(|entry| (entry.name.value.clone(), entry.name.span)).collect();
    for topic in &face.topics {
        known.push((topic.name.text.clone(), topic.name.at.unwrap_or(component.name.span)));
    }
    for rename in &component.rename {
        if !known.iter().any(|(name, _)| *name == rename.from.value) {
            report.found(TopicError::UnknownRename {
                component: component.name.value.clone(),
                name: rename.from.value.clone(),
                at: rename.from.span,
                known: known.clone(),
            });
        }
    }
}
