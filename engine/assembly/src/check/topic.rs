//! Topics: one type over all publishers and subscribers, and somebody who publishes.

use std::collections::BTreeMap;

use asmotion_component::{BusHealth, HEALTH_TOPIC};
use asmotion_datum::Message;
use asmotion_diagnostics::{Diagnostic, Report, Span};

use super::codec;
use super::component::topic;
use super::connection::TopicLink;
use super::connection_error::ConnectionError;
use super::face::Kind;
use super::scene::{Part, Scene};
use super::wire::own_place;
use crate::finding::{Finding, Findings};
use crate::model::{self, Promoted};
use crate::nearest::{Nearest, Suggest, nearest};
use crate::read::error::ReadError;

#[derive(Debug, thiserror::Error)]
pub(crate) enum TopicError {
    #[error("topic `{topic}` has two types: `{kind}` and `{other}`")]
    TwoTypes {
        topic: String,
        kind: String,
        other: String,
        at: Span,
        other_at: Span,
    },
    #[error("nobody publishes `{topic}`")]
    Silent {
        topic: String,
        at: Span,
        written: Written,
        nearest: Option<Nearest>,
    },
    #[error("`{component}` neither subscribes nor publishes `{name}`, so it cannot be renamed")]
    UnknownRename {
        component: String,
        name: String,
        at: Span,
        known: Vec<(String, Span)>,
    },
    #[error("topic `{HEALTH_TOPIC}` is the engine's own: it tells there how its bus is")]
    Own { at: Span, problem: OwnProblem },
    #[error("nothing is on topic `{topic}`")]
    Unused {
        topic: String,
        at: Span,
        nearest: Option<Nearest>,
    },
    #[error("output `{port}` is on two topics: `{first}` and `{second}`")]
    TwoTopics {
        port: String,
        first: String,
        first_at: Span,
        second: String,
        at: Span,
    },
}

impl Finding for TopicError {
    fn diagnostic(&self) -> Diagnostic {
        match self {
            Self::TwoTypes {
                kind,
                other,
                at,
                other_at,
                ..
            } => Diagnostic::error("C050", self)
                .label(*at, format!("`{kind}` here"))
                .label(*other_at, format!("`{other}` here"))
                .help("rename one of the two, or use one type"),
            Self::Silent {
                topic,
                at,
                written,
                nearest,
            } => {
                let diagnostic = Diagnostic::warning("C051", self).label(*at, "subscribed here");
                let Some(Nearest { name, declared }) = nearest else {
                    return diagnostic.help(format!(
                        "if it comes from outside, write `[[promote]]` with `topic = \"{topic}\"`"
                    ));
                };
                let diagnostic = match declared {
                    Some(declared) => {
                        diagnostic.label(*declared, format!("`{name}` is published here"))
                    }
                    None => diagnostic,
                };
                match written {
                    Written::At(span) => {
                        diagnostic.guess(format!("did you mean `{name}`?"), *span, name)
                    }
                    Written::AsPort(port) => diagnostic.help(format!(
                        "did you mean `rename = {{ {port} = \"{name}\" }}`?"
                    )),
                }
            }
            Self::UnknownRename {
                name, at, known, ..
            } => {
                let all = known.iter().map(|(name, at)| (name.as_str(), Some(*at)));
                Diagnostic::error("C052", self)
                    .label(*at, "no such topic")
                    .suggest_or(
                        *at,
                        &nearest(name, all),
                        "left is the name in the component, right the topic",
                    )
            }
            Self::Own { at, problem } => {
                let diagnostic = Diagnostic::error("C055", self);
                match problem {
                    OwnProblem::Published => diagnostic
                        .label(*at, "published here")
                        .help("publish on another topic: rename it"),
                    OwnProblem::Type(kind) => diagnostic
                        .label(*at, format!("`{kind}` here"))
                        .help(format!("its messages are of type `{}`", BusHealth::NAME)),
                }
            }
            Self::Unused { at, nearest, .. } => Diagnostic::error("C056", self)
                .label(*at, "no such topic")
                .suggest_or(*at, nearest, "here stands how a topic goes over a broker"),
            Self::TwoTopics { at, first_at, .. } => Diagnostic::error("C053", self)
                .label(*at, "the second topic")
                .label(*first_at, "the first topic")
                .help("an output writes one topic; whoever wants another name renames it"),
        }
    }
}

/// What is wrong with a use of the engine's own topic.
#[derive(Debug)]
pub(crate) enum OwnProblem {
    /// Somebody else publishes it.
    Published,
    /// Somebody reads it as messages of this type.
    Type(String),
}

/// The topics of a composite in one profile, by name.
pub(crate) type Topics = BTreeMap<String, Vec<Role>>;

/// Somebody who publishes or subscribes a topic.
pub(crate) struct Role {
    pub at: Span,
    pub kind: Option<Kind>,
    pub published: bool,
    pub subscribed: bool,
    /// Component and port; `None` for a topic that a nested composite promotes.
    port: Option<(String, String)>,
    written: Written,
}

impl Role {
    /// Who publishes or subscribes, if it is no nested composite.
    pub(crate) fn component(&self) -> Option<&str> {
        self.port.as_ref().map(|(component, _)| component.as_str())
    }
}

/// How the topic's name came about.
#[derive(Clone, Debug)]
pub(crate) enum Written {
    /// It stands at a place, where it can be replaced.
    At(Span),
    /// It is the name of the port.
    AsPort(String),
}

/// Checks all topics, and returns them.
pub(crate) fn check(scene: &Scene<'_>, links: &[TopicLink], report: &mut Report) -> Topics {
    for part in &scene.parts {
        renames(part, report);
    }
    let topics = collect(scene, links);
    let promotions = scene.composite.promotions.iter();
    let active = promotions.filter(|promotion| scene.active(&promotion.profiles));
    let promoted: Vec<&str> = active
        .filter_map(|promotion| match &promotion.what {
            Promoted::Topic(topic) => Some(topic.value.as_str()),
            _ => None,
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

fn collect(scene: &Scene<'_>, links: &[TopicLink]) -> Topics {
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

/// A renamed topic stands in the rename.
fn written(part: &Part<'_>, name: &str) -> Written {
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

fn types(scene: &Scene<'_>, topic: &str, roles: &[Role], report: &mut Report) {
    let mut typed = roles
        .iter()
        .filter_map(|role| Some((role, role.kind.as_ref()?)));
    let Some((first_role, first)) = typed.next() else {
        return;
    };
    for (role, kind) in typed.filter(|(_, kind)| !scene.types.same(&kind.text, &first.text)) {
        report.found(TopicError::TwoTypes {
            topic: topic.to_owned(),
            kind: kind.text.clone(),
            other: first.text.clone(),
            at: kind.at.unwrap_or(role.at),
            other_at: first.at.unwrap_or(first_role.at),
        });
    }
}

/// The engine alone publishes how its bus is.
fn own(scene: &Scene<'_>, roles: &[Role], report: &mut Report) {
    for role in roles {
        if role.published {
            let problem = OwnProblem::Published;
            report.found(TopicError::Own {
                at: role.at,
                problem,
            });
        }
        let Some(kind) = &role.kind else { continue };
        if !scene.types.same(&kind.text, BusHealth::NAME) {
            let problem = OwnProblem::Type(kind.text.clone());
            let at = kind.at.unwrap_or(role.at);
            report.found(TopicError::Own { at, problem });
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
    report.found(TopicError::Silent {
        topic: topic.to_owned(),
        at: subscriber.at,
        written: subscriber.written.clone(),
        nearest: nearest(topic, published),
    });
}

fn renames(part: &Part<'_>, report: &mut Report) {
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

/// How a topic is sent is said of one that is there; a queue has a size.
fn sending(topic: &model::Topic, topics: &Topics, report: &mut Report) {
    let (name, at) = (&topic.name.value, topic.name.span);
    if !topics.contains_key(name) || name == HEALTH_TOPIC {
        let known = topics
            .iter()
            .filter_map(|(name, roles)| Some((name.as_str(), Some(roles.first()?.at))));
        report.found(TopicError::Unused {
            topic: name.clone(),
            at,
            nearest: nearest(name, known),
        });
    }
    let outage = topic.outage.as_ref();
    match (outage.map(|outage| outage.value), &topic.size) {
        (Some(model::Outage::Queue), None) => report.found(ReadError::MissingKey {
            key: "size",
            of: "a queue",
            at: outage.map_or(at, |outage| outage.span),
            example: "64".to_owned(),
        }),
        (None | Some(model::Outage::Drop | model::Outage::Latest), Some(size)) => {
            report.found(ConnectionError::Idle {
                key: "size",
                at: size.span,
                reason: "only `outage = \"queue\"` has a size",
            });
        }
        (Some(model::Outage::Queue), Some(_)) | (None | Some(_), None) => {}
    }
}

/// An output writes one topic.
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
            report.found(TopicError::TwoTopics {
                port: format!("{}.{}", port.0, port.1),
                first: other.clone(),
                first_at,
                second: topic.clone(),
                at: role.at,
            });
        }
    }
}
