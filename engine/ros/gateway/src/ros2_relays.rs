//! Bridges of several composites whose relays between topics of ROS 2 form a circle.
//!
//! A bridge announces each of its relays by a publisher that never publishes, on a topic whose name contains both topics. Discovery
//! brings it to all other nodes, also to those that join later, with the id of the participant; DDS leaves no room of its own
//! for this, because `rustdds` does not write the user data of endpoints. The name begins with an underscore: tools of ROS do not
//! list such topics. Publishers are created in this order, and DDS announces them in it: a peer knows the relay before it
//! matches the publisher of the topic.

use std::collections::{BTreeMap, BTreeSet};

use asmotion_ros_interface::InterfaceName;
use asmotion_ros2::{EndpointError, Gid, Node, Publisher, Qos, Subscription};

/// Type of the announcements.
const TYPE: &str = "std_msgs/Empty";

/// Prefix of the names of announcements.
const ANNOUNCEMENT: &str = "/_asmotion_relay";
/// Separator of the two topics.
const TO: &str = "/_to/";

/// The name of the announcement of a relay between two absolute topics.
fn announcement(from: &str, to: &str) -> String {
    format!("{ANNOUNCEMENT}{from}/_to{to}")
}

/// The two absolute topics of an announcement.
fn announced(name: &str) -> Option<(&str, &str)> {
    let topics = name.strip_prefix(ANNOUNCEMENT)?;
    let middle = topics.find(TO)?;
    // the slash belongs to the second topic
    let (from, to) = topics.split_at(middle);
    Some((from, to.get(TO.len() - 1..)?))
}

/// The relays of a node.
#[derive(Default)]
pub(crate) struct AnnouncedRelays {
    /// Absolute topics whose messages the bridge publishes on others, with those.
    relays: Vec<(String, String)>,
    _announcements: Vec<Publisher>,
}

impl AnnouncedRelays {
    /// Announces relays from one topic to another.
    ///
    /// # Errors
    /// A text is not the name of a topic, or DDS refuses a publisher.
    pub(crate) fn announce(node: &Node, relays: &[(String, String)]) -> Result<Self, String> {
        let text = |error: EndpointError| error.to_string();
        let of: InterfaceName = TYPE.parse().map_err(|error| format!("{error}"))?;
        let (mut resolved, mut announcements) = (Vec::new(), Vec::new());
        for (from, to) in relays {
            let (from, to) = (
                node.absolute(from).map_err(text)?,
                node.absolute(to).map_err(text)?,
            );
            let name = announcement(&from, &to);
            let publisher = node.publisher(&name, &of, Qos::default());
            announcements.push(publisher.map_err(text)?);
            resolved.push((from, to));
        }
        Ok(Self {
            relays: resolved,
            _announcements: announcements,
        })
    }

    /// What would go round, of the messages of a topic.
    pub(crate) fn circles(&self, node: &Node, topic: &str) -> Result<Circles, String> {
        let topic = node.absolute(topic).map_err(|error| error.to_string())?;
        let is_relayed = self.relays.iter().any(|(from, _)| *from == topic);
        Ok(Circles {
            topic,
            own: if is_relayed {
                self.relays.clone()
            } else {
                Vec::new()
            },
            revision: None,
            closing: BTreeMap::new(),
            refused: BTreeSet::new(),
        })
    }
}

/// Recognises publishers of a topic whose messages would go round.
pub(crate) struct Circles {
    /// The absolute topic.
    topic: String,
    /// The relays of this node; empty if it relays the topic nowhere.
    own: Vec<(String, String)>,
    /// The graph that `closing` was computed from.
    revision: Option<u64>,
    /// Participants that relay to the topic what comes from it, with the topics that it comes through.
    closing: BTreeMap<[u8; 12], Vec<String>>,
    /// Publishers that were recognised.
    refused: BTreeSet<Gid>,
}

impl Circles {
    /// Returns whether the messages of a publisher would go round, and the reason for display if it was not known before.
    pub(crate) fn check(
        &mut self,
        subscription: &Subscription,
        writer: Gid,
    ) -> (bool, Option<String>) {
        if self.own.is_empty() {
            return (false, None);
        }
        let revision = subscription.graph_revision();
        if self.revision.replace(revision) != Some(revision) {
            let found = subscription.topics_of_peers(ANNOUNCEMENT);
            let relays = found.iter().filter_map(|(name, participant)| {
                let (from, to) = announced(name)?;
                Some((from, to, *participant))
            });
            self.closing = closing(&self.topic, &self.own, &relays.collect::<Vec<_>>());
        }
        let Some(way) = self.closing.get(&writer.participant()) else {
            return (false, None);
        };
        if !self.refused.insert(writer) {
            return (true, None);
        }
        let node = subscription.node_of(writer);
        let node = node.map_or("a peer".to_owned(), |name| format!("`{name}`"));
        (true, Some(reason(&self.topic, &node, way)))
    }
}

/// Why the messages of a node would go round, which come to it through these topics.
fn reason(topic: &str, node: &str, way: &[String]) -> String {
    let (next, last) = (way.first(), way.last());
    let (Some(next), Some(last)) = (next, last) else {
        return format!("`{topic}`: messages of {node} would go round");
    };
    let between = match way {
        [_] => String::new(),
        longer => {
            let topics: Vec<_> = longer.iter().map(|it| format!("`{it}`")).collect();
            format!(", from where they come through {}", topics.join(", "))
        }
    };
    format!(
        "`{topic}`: messages would go round: {node} relays `{last}` to `{topic}`, and this node `{topic}` to `{next}`{between}"
    )
}

/// The participants that relay to a topic what comes from it, with the topics that it comes through, the first one of this node's
/// relays.
fn closing(
    topic: &str,
    own: &[(String, String)],
    peers: &[(&str, &str, [u8; 12])],
) -> BTreeMap<[u8; 12], Vec<String>> {
    let own = own.iter().map(|(from, to)| (&**from, &**to));
    let edges = own.chain(peers.iter().map(|(from, to, _)| (*from, *to)));
    let edges: BTreeSet<(&str, &str)> = edges.collect();
    let onward = |from: &str| {
        let edges = edges.iter().filter(move |it| it.0 == from);
        edges.map(|it| it.1).collect::<Vec<_>>()
    };
    // the shortest way to each topic
    let mut ways: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    let mut next: Vec<(&str, Vec<String>)> = vec![(topic, Vec::new())];
    while !next.is_empty() {
        let mut found = Vec::new();
        for (from, way) in next {
            for to in onward(from) {
                if to != topic && !ways.contains_key(to) {
                    let way: Vec<String> = way.iter().cloned().chain([to.to_owned()]).collect();
                    ways.insert(to, way.clone());
                    found.push((to, way));
                }
            }
        }
        next = found;
    }
    let back = peers.iter().filter(|(_, to, _)| *to == topic);
    let back = back.filter_map(|(from, _, participant)| {
        let way = ways.get(from)?;
        Some((*participant, way.clone()))
    });
    back.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn owned(relays: &[(&str, &str)]) -> Vec<(String, String)> {
        let relays = relays.iter();
        relays
            .map(|(from, to)| ((*from).to_owned(), (*to).to_owned()))
            .collect()
    }

    #[test]
    fn an_announcement_names_both_topics() {
        let name = announcement("/robot/a", "/b");
        assert_eq!(announced(&name), Some(("/robot/a", "/b")));
        assert_eq!(announced("/_asmotion_relay/a"), None);
        assert_eq!(announced("/a/_to/b"), None);
    }

    #[test]
    fn what_closes_a_circle_is_recognised_however_long_it_is() {
        let [second, third, other] = [[2; 12], [3; 12], [4; 12]];
        let own = owned(&[("/a", "/b")]);
        let peers = [
            ("/b", "/c", second),
            ("/c", "/a", third),
            ("/x", "/a", other),
        ];
        let found = closing("/a", &own, &peers);
        assert_eq!(found, BTreeMap::from([(third, owned_way(&["/b", "/c"]))]));
        assert_eq!(
            reason("/a", "`/third`", &found[&third]),
            "`/a`: messages would go round: `/third` relays `/c` to `/a`, and this node `/a` to `/b`, from where they come through `/b`, `/c`"
        );
        // one link less, and it is none
        assert_eq!(closing("/a", &own, &peers[1..]), BTreeMap::new());
        // with two relays of this node
        let own = owned(&[("/a", "/b"), ("/b", "/c")]);
        let found = closing("/a", &own, &[("/c", "/a", third)]);
        assert_eq!(found, BTreeMap::from([(third, owned_way(&["/b", "/c"]))]));
        let found = closing("/a", &own, &[("/b", "/a", third)]);
        assert_eq!(
            reason("/a", "a peer", &found[&third]),
            "`/a`: messages would go round: a peer relays `/b` to `/a`, and this node `/a` to `/b`"
        );
    }

    fn owned_way(way: &[&str]) -> Vec<String> {
        way.iter().map(|it| (*it).to_owned()).collect()
    }
}
