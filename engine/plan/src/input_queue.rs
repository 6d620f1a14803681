//! The queues in which messages wait for input ports.

use crate::joint::Connection;
use crate::plan::Plan;
use asmotion_composite::end::{End, Terminal};
use asmotion_composite::model::{ConnectionType, Sharing};

/// The queue that the connections to an input port, or into a topic, form together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InputQueue {
    /// Number of messages that it holds, at least 1.
    pub size: u64,
    /// `true` if a new message takes the place of the oldest one when it is full; otherwise the new one is dropped.
    pub is_circular: bool,
}

impl InputQueue {
    /// The queue of a connection; `None` if the connection keeps only the newest message.
    fn of(connection: &Connection) -> Option<Self> {
        let is_circular = match connection.policy.kind {
            ConnectionType::Data => return None,
            ConnectionType::Buffer => false,
            ConnectionType::Circular => true,
        };
        Some(Self {
            size: connection.policy.size.max(1),
            is_circular,
        })
    }

    /// A queue as large as both together.
    fn and(self, other: Self) -> Self {
        Self {
            size: self.size.saturating_add(other.size),
            is_circular: self.is_circular || other.is_circular,
        }
    }
}

/// Adds up queues; `None` if there are none, or if one connection keeps only the newest message.
fn sum(queues: impl IntoIterator<Item = Option<InputQueue>>) -> Option<InputQueue> {
    let queues: Option<Vec<InputQueue>> = queues.into_iter().collect();
    queues?.into_iter().reduce(InputQueue::and)
}

impl Plan {
    /// Returns the queue that the connections into a topic form together; `None` if there are none, or if one of them keeps only
    /// the newest message.
    pub fn topic_queue(&self, topic: &str) -> Option<InputQueue> {
        let topic = Terminal::Topic(topic.to_owned());
        sum(self.connections.to_end(&topic).map(InputQueue::of))
    }

    /// Returns the queue of an input port; `None` if no size is written for one of its connections, or if it keeps only the
    /// newest message.
    pub fn input_queue(&self, port: &End) -> Option<InputQueue> {
        let to = Terminal::Port(port.clone());
        let connections: Vec<&Connection> = self.connections.to_end(&to).collect();
        let is_of_input = |it: &&&Connection| it.policy.buffer == Sharing::PerInput;
        let common = connections.iter().filter(is_of_input);
        let common = common
            .filter_map(|it| InputQueue::of(it))
            .max_by_key(|it| it.size);
        let own = connections.iter().filter(|it| !is_of_input(it));
        let own = own.map(|it| InputQueue::of(it));
        let subscribed = self.topics.iter().filter(|topic| {
            let is_connected = connections
                .iter()
                .any(|it| it.from == Terminal::Topic(topic.name.clone()));
            topic.subscribers.contains(port) && !is_connected
        });
        let subscribed = subscribed.map(|topic| self.topic_queue(&topic.name));
        sum(own.chain(subscribed).chain(common.map(Some)))
    }
}
