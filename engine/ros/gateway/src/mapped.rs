//! A topic of a composite and a topic of ROS that a bridge joins.

use std::time::Duration;

use asmotion_bridge::FieldConverter;
use asmotion_datum::Schema;

/// A mapping between a port of the bridge and a topic of ROS.
#[derive(Clone, Debug, PartialEq)]
pub struct MappedTopic {
    /// Port of the bridge.
    pub port: String,
    /// Topic of the composite that the port is on; `None` if the port is connected directly.
    pub topic: Option<String>,
    /// Schema of the port.
    pub schema: Schema,
    /// Topic of ROS, such as `/plan`.
    pub ros: String,
    /// Type in ROS, such as `nav_msgs/Path`.
    pub kind: String,
    /// Messages that wait for each subscriber, or for the bridge; then the oldest one is dropped.
    pub queue: usize,
    /// `true` to send the last message to subscribers in ROS that join later.
    pub is_latched: bool,
    /// ROS 2: `true` for messages that are not repeated when they are lost.
    pub is_best_effort: bool,
    /// ROS 2: longest time between two messages.
    pub deadline: Option<Duration>,
    /// ROS 2: age at which messages are no longer delivered.
    pub lifespan: Option<Duration>,
    /// Converters of fields, in their order.
    pub converters: Vec<FieldConverter>,
    /// Frame into which messages are transformed, if they are.
    pub transform: Option<MappedFrame>,
    /// Direction of the messages.
    pub direction: RosDirection,
}

/// A frame into which messages are transformed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MappedFrame {
    /// Name of the frame.
    pub frame: String,
    /// Longest wait of a message for its transforms.
    pub timeout: Duration,
}

/// A topic of the composite and a topic of ROS.
pub(crate) type JoinedTopics = (String, String);

impl MappedTopic {
    /// The topics that it joins; `None` if the port is on no topic.
    pub(crate) fn joined_topics(&self) -> Option<JoinedTopics> {
        Some((self.topic.clone()?, self.ros.clone()))
    }
}

/// Direction of the messages of a mapping.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RosDirection {
    /// From the composite to ROS.
    ToRos,
    /// From ROS to the composite.
    FromRos,
}
