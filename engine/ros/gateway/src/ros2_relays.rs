//! Bridges of two composites that relay between the same two topics of ROS 2 in opposite directions.
//!
//! A bridge announces each of its relays by a publisher that never publishes, on a topic whose name contains both topics. Discovery
//! brings it to all other nodes, also to those that join later, with the id of the participant; DDS leaves no room of its own
//! for this, because `rustdds` does not write the user data of endpoints. The name begins with an underscore: tools of ROS do not
//! list such topics. Publishers are created in this order, and DDS announces them in it: a peer knows the relay before it
//! matches the publisher of the topic.

use std::collections::BTreeSet;

use asmotion_ros_interface::InterfaceName;
use asmotion_ros2::{EndpointError, Gid, Node, Publisher, Qos, Subscription};

/// Type of the announcements.
const TYPE: &str = "std_msgs/Empty";

/// The name of the announcement of a relay between two absolute topics.
fn announcement(from: &str, to: &str) -> String {
    format!("/_asmotion_relay{from}/_to{to}")
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
        let onward = self.relays.iter().filter(|(from, _)| *from == topic);
        let onward = onward.map(|(_, to)| to.clone()).collect();
        Ok(Circles {
            topic,
            onward,
            refused: BTreeSet::new(),
        })
    }
}

/// Recognises publishers of a topic whose messages would go round.
pub(crate) struct Circles {
    /// The absolute topic.
    topic: String,
    /// Topics on which this node publishes its messages.
    onward: Vec<String>,
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
        if self.onward.is_empty() {
            return (false, None);
        }
        if self.refused.contains(&writer) {
            return (true, None);
        }
        let mut onward = self.onward.iter();
        let back = onward.find(|back| {
            let name = announcement(back, &self.topic);
            subscription.is_written_by(&name, writer.participant())
        });
        let Some(back) = back else {
            return (false, None);
        };
        self.refused.insert(writer);
        let node = subscription.node_of(writer);
        let node = node.map_or("a peer".to_owned(), |name| format!("`{name}`"));
        let topic = &self.topic;
        let reason = format!(
            "`{topic}`: messages would go round: {node} relays `{back}` to `{topic}`, and this node `{topic}` to `{back}`"
        );
        (true, Some(reason))
    }
}
