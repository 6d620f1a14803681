//! Checks topics: a common message type for all publishers and subscribers, and at least one publisher.

use std::borrow::Cow;

use crate::codes::c004::MissingKey;
use crate::codes::c048::IdleKey;
use crate::codes::c050::TopicWithTwoTypes;
use crate::codes::c051::{SilentTopic, Written};
use crate::codes::c052::UnknownRename;
use crate::codes::c053::OutputOnTwoTopics;
use crate::codes::c055::{EngineTopic, OwnProblem};
use crate::codes::c056::UnknownTopicSettings;
use std::collections::BTreeMap;

use asmotion_component::{BusHealth, HEALTH_TOPIC};
use asmotion_datum::Message;
use asmotion_diagnostics::{Report, Span};

use super::codec;
use super::component::topic;
use super::connection::TopicLink;
use super::endpoints::TypeAt;
use super::scene::{CheckedComponent, CheckedComposite};
use super::wire::own_place;
use crate::finding::Findings;
use crate::model::{self, Promoted};
use crate::nearest::nearest;

/// Publishers and subscribers by topic name, in one profile.
pub(crate) type Topics = BTreeMap<String, Vec<Role>>;

/// A publisher or subscriber of a topic.
pub(crate) struct Role {
    pub at: Span,
    pub kind: Option<TypeAt>,
    pub published: bool,
    pub subscribed: bool,
    /// Component and port; `None` for a topic promoted by a nested composite.
    port: Option<(String, String)>,
    written: Written,
}

impl Role {
    /// Returns the component name; `None` for a nested composite.
    pub(crate) fn component(&self) -> Option<&str> {
        self.port.as_ref().map(|(component, _)| component.as_str())
    }
}

/// Checks all topics and returns them.
pub(crate) fn check(
    scene: &CheckedComposite<'_>,
    links: &[TopicLink],
    report: &mut Report,
) -> Topics {
    for part in &scene.parts {
        renames(scene, part, report);
    }
    let topics = collect(scene, links);
    let promotions = scene.composite.promotions.iter();
    let active = promotions.filter(|promotion| scene.active(&promotion.profiles));
    let promoted: Vec<&str> = active
        .filter_map(|promotion| {
            let Promoted::Topic(topic) = &promotion.what else {
                return None;
            };
            Some(topic.value.as_str())
        })
        .collect();
    for (topic, roles) in &topics {
        if topic == HEALTH_TOPIC {
            own(scene, roles, report);
            continue;
        }
        types(scene, topic, roles, report);
        if !promoted.contains(&topic.as_str()) {
            silent(topic, roles, &topics, report);
        }
    }
    two_topics(&topics, report);
    for topic in &scene.composite.topics {
        sending(topic, &topics, report);
    }
    codec::topics(scene, &topics, report);
    topics
}

fn collect(scene: &CheckedComposite<'_>, links: &[TopicLink]) -> Topics {
    let mut topics = Topics::new();
    let mut add = |name: &str, role: Role| topics.entry(name.to_owned()).or_default().push(role);
    for part in &scene.parts {
        let component = &part.component.name.value;
        let ports = part.face.inputs.iter().map(|port| (false, port));
        for (published, port) in ports.chain(part.face.outputs.iter().map(|port| (true, port))) {
            if let Some(topic) = &port.topic {
                let role = Role {
                    at: own_place(part, port.name.at),
                    kind: port.kind.clone(),
                    published,
                    subscribed: !published,
                    port: Some((component.clone(), port.name.text.clone())),
                    written: written(part, &port.name.text),
                };
                add(topic, role);
            }
        }
        for promoted in &part.face.topics {
            let role = Role {
                at: part.component.name.span,
                kind: promoted.kind.clone(),
                published: promoted.published,
                subscribed: promoted.subscribed,
                port: None,
                written: written(part, &promoted.name.text),
            };
            add(&topic(part.component, &promoted.name.text), role);
        }
    }
    for link in links {
        let role = Role {
            at: link.at,
            kind: link.kind.clone(),
            published: link.published,
            subscribed: !link.published,
            port: Some(link.port.clone()),
            written: Written::At(link.at),
        };
        add(&link.topic, role);
    }
    topics
}

/// Returns the origin of the topic name: a `rename` entry or the port itself.
fn written(part: &CheckedComponent<'_>, name: &str) -> Written {
    let rename = part
        .component
        .rename
        .iter()
        .find(|rename| rename.from.value == name);
    match rename {
        Some(rename) => Written::At(rename.to.span),
        None => Written::AsPort(name.to_owned()),
    }
}

fn types(scene: &CheckedComposite<'_>, topic: &str, roles: &[Role], report: &mut Report) {
    let mut typed = roles
        .iter()
        .filter_map(|role| Some((role, role.kind.as_ref()?)));
    let Some((first_role, first)) = typed.next() else {
        return;
    };
    for (role, kind) in typed.filter(|(_, kind)| !scene.types.same(&kind.text, &first.text)) {
        report.found(TopicWithTwoTypes {
            topic: topic.to_owned(),
            kind: kind.text.clone(),
            other: first.text.clone(),
            at: kind.at.unwrap_or(role.at),
            other_at: first.at.unwrap_or(first_role.at),
        });
    }
}

/// Reports components that publish the reserved topic of the bus state or subscribe to it with another type.
fn own(scene: &CheckedComposite<'_>, roles: &[Role], report: &mut Report) {
    for role in roles {
        if role.published {
            let problem = OwnProblem::Published;
            report.found(EngineTopic {
                at: role.at,
                problem,
            });
        }
        let Some(kind) = &role.kind else { continue };
        if !scene.types.same(&kind.text, BusHealth::NAME) {
            let problem = OwnProblem::Type(kind.text.clone());
            let at = kind.at.unwrap_or(role.at);
            report.found(EngineTopic { at, problem });
        }
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
    report.found(SilentTopic {
        topic: topic.to_owned(),
        at: subscriber.at,
        written: subscriber.written.clone(),
        nearest: nearest(topic, published),
    });
}

fn renames(scene: &CheckedComposite<'_>, part: &CheckedComponent<'_>, report: &mut Report) {
    if part.face.blank {
        return;
    }
    let component = part.component;
    let listed = component.subscribe.iter().chain(&component.publish);
    let mut known: Vec<(String, Span)> = listed
        .map(|entry| (entry.name.value.clone(), entry.name.span))
        .collect();
    for topic in &part.face.topics {
        known.push((
            topic.name.text.clone(),
            topic.name.at.unwrap_or(component.name.span),
        ));
    }
    for rename in &component.rename {
        // a composite undoes a rename of its base in this way
        if rename.from.value == rename.to.value && scene.composite.base.is_none() {
            report.found(IdleKey {
                key: Cow::Borrowed("rename"),
                at: rename.to.span,
                reason: "the topic has this name without it",
            });
        }
        if !known.iter().any(|(name, _)| *name == rename.from.value) {
            report.found(UnknownRename {
                component: component.name.value.clone(),
                name: rename.from.value.clone(),
                at: rename.from.span,
                known: known.clone(),
            });
        }
    }
}

/// Checks the settings of a topic: the topic exists, and `size` is given exactly if `outage` is `queue`.
fn sending(topic: &model::Topic, topics: &Topics, report: &mut Report) {
    let (name, at) = (&topic.name.value, topic.name.span);
    if !topics.contains_key(name) || name == HEALTH_TOPIC {
        let known = topics
            .iter()
            .filter_map(|(name, roles)| Some((name.as_str(), Some(roles.first()?.at))));
        report.found(UnknownTopicSettings {
            topic: name.clone(),
            at,
            nearest: nearest(name, known),
        });
    }
    let outage = topic.outage.as_ref();
    match (outage.map(|outage| outage.value), &topic.size) {
        (Some(model::Outage::Queue), None) => report.found(MissingKey {
            key: "size",
            of: "a queue",
            at: outage.map_or(at, |outage| outage.span),
            example: "64".to_owned(),
        }),
        (None | Some(model::Outage::Drop | model::Outage::Latest), Some(size)) => {
            report.found(IdleKey {
                key: Cow::Borrowed("size"),
                at: size.span,
                reason: "only `outage = \"queue\"` has a size",
            });
        }
        (Some(model::Outage::Queue), Some(_)) | (None | Some(_), None) => {}
    }
}

/// Reports output ports that publish to more than one topic.
fn two_topics(topics: &Topics, report: &mut Report) {
    let roles = topics
        .iter()
        .flat_map(|(topic, roles)| roles.iter().map(move |it| (topic, it)));
    let mut published: Vec<(&String, &Role)> = roles.filter(|(_, role)| role.published).collect();
    published.sort_by_key(|(_, role)| role.at);
    let mut first: BTreeMap<&(String, String), (&String, Span)> = BTreeMap::new();
    for (topic, role) in published {
        let Some(port) = &role.port else {
            continue;
        };
        let (other, first_at) = *first.entry(port).or_insert((topic, role.at));
        if other != topic {
            report.found(OutputOnTwoTopics {
                port: format!("{}.{}", port.0, port.1),
                first: other.clone(),
                first_at,
                second: topic.clone(),
                at: role.at,
            });
        }
    }
}
