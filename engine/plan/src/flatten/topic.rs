//! Resolves topics: system-wide names, publishers and subscribers.

use std::collections::BTreeMap;

use asmotion_component::HEALTH_TOPIC;

use super::Flattener;
use crate::component::Port;
use crate::joint::Topic;
use crate::plan::{End, Terminal};
use asmotion_composite::check;
use asmotion_composite::model::{self, Composite, PlannedSending};
use asmotion_composite::table::Resolver;

impl Flattener<'_, '_> {
    /// Returns the system-wide name of a topic. Topics of a nested composite are private unless promoted.
    pub(super) fn topic(&self, index: usize, name: &str) -> String {
        // the topic of the bus state has the same name in all composites
        if name == HEALTH_TOPIC {
            return name.to_owned();
        }
        let Some(instance) = self.instances.get(index) else {
            return name.to_owned();
        };
        let Some((parent, component)) = instance.parent else {
            return name.to_owned();
        };
        let promotion = instance.member.composite.promotions.iter().find(|promotion| {
            check::takes_part(&promotion.profiles, self.parts.profile)
                && matches!(&promotion.what, model::Promoted::Topic(topic) if topic.value == name)
        });
        match promotion {
            Some(promotion) => self.topic(parent, &check::topic(component, &promotion.name.value)),
            None => format!("{}{name}", instance.prefix),
        }
    }

    /// Collects the topics used by ports and connections.
    pub(super) fn topics(&mut self, composite: &Composite) {
        let mut topics: BTreeMap<String, Topic> = BTreeMap::new();
        for role in self.topic_roles() {
            let (name, end) = (role.topic, role.end);
            let topic = topics.entry(name.clone()).or_insert_with(|| Topic {
                name: name.clone(),
                kind: None,
                promoted: false,
                sending: PlannedSending {
                    name,
                    confirm: None,
                    outage: None,
                    size: None,
                    codec: None,
                },
                publishers: Vec::new(),
                subscribers: Vec::new(),
            });
            topic.kind = topic.kind.take().or(role.kind);
            if role.writes {
                topic.publishers.push(end)
            } else {
                topic.subscribers.push(end)
            }
        }
        for promotion in &composite.promotions {
            if let model::Promoted::Topic(topic) = &promotion.what
                && check::takes_part(&promotion.profiles, self.parts.profile)
                && let Some(topic) = topics.get_mut(&topic.value)
            {
                topic.promoted = true;
            }
        }
        self.sending(&mut topics);
        self.plan.topics = topics.into_values().collect();
    }

    /// The ports that write to topics and read them: those of components, then those of connections.
    fn topic_roles(&self) -> Vec<TopicRole> {
        let mut roles: Vec<TopicRole> = Vec::new();
        for component in &self.plan.components {
            for (ports, writes) in [(&component.inputs, false), (&component.outputs, true)] {
                for port in ports {
                    if let Some(topic) = &port.topic {
                        let (component, name) = (component.name.clone(), port.name.clone());
                        roles.push(TopicRole {
                            topic: topic.clone(),
                            kind: message_kind(port),
                            end: End { component, name },
                            writes,
                        });
                    }
                }
            }
        }
        let role = |topic: &String, end: &End, writes| TopicRole {
            topic: topic.clone(),
            kind: self.kind(end, writes),
            end: end.clone(),
            writes,
        };
        for connection in &self.plan.connections {
            match (&connection.from, &connection.to) {
                (Terminal::Port(end), Terminal::Topic(topic)) => {
                    roles.push(role(topic, end, true));
                }
                (Terminal::Topic(topic), Terminal::Port(end)) => {
                    roles.push(role(topic, end, false));
                }
                // the others do not involve topics; connections between topics are rejected by the checker
                (Terminal::Port(_), Terminal::Port(_))
                | (Terminal::Mqueue(_), _)
                | (_, Terminal::Mqueue(_))
                | (Terminal::Topic(_), Terminal::Topic(_)) => {}
            }
        }
        roles
    }

    /// Applies the topic settings of all composites; the outer composite takes precedence for shared topics.
    fn sending(&mut self, topics: &mut BTreeMap<String, Topic>) {
        for (index, instance) in self.instances.iter().enumerate() {
            for written in &instance.member.composite.topics {
                let name = self.topic(index, &written.name.value);
                let mut to = Resolver::new(&instance.scope, &instance.prefix, self.notes);
                let (Some(topic), Some(outer)) = (topics.get_mut(&name), to.of(written)) else {
                    continue;
                };
                let sending = &mut topic.sending;
                sending.confirm = sending.confirm.or(outer.confirm);
                sending.outage = sending.outage.or(outer.outage);
                sending.size = sending.size.or(outer.size);
                sending.codec = sending.codec.or(outer.codec);
            }
        }
    }

    fn kind(&self, end: &End, writes: bool) -> Option<String> {
        let component = self.plan.component(&end.component)?;
        let ports = if writes {
            &component.outputs
        } else {
            &component.inputs
        };
        message_kind(ports.iter().find(|port| port.name == end.name)?)
    }
}

/// A port that writes to a topic or reads it.
struct TopicRole {
    topic: String,
    kind: Option<String>,
    end: End,
    writes: bool,
}

/// The message type of a port; `None` if it is not known.
fn message_kind(port: &Port) -> Option<String> {
    (!port.kind.is_empty()).then(|| port.kind.clone())
}
