//! Errors of operations on a node.

use crate::names::RosNameError;

/// Error of an operation on a node.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RosError {
    /// A text is not a name.
    #[error(transparent)]
    Name(#[from] RosNameError),
    /// The node has a publisher of this topic.
    #[error(
        "the node already publishes `{topic}`, with the type `{declared}`; it was declared again with `{again}`"
    )]
    Published {
        /// Name of the topic.
        topic: String,
        /// Type of the first publisher.
        declared: String,
        /// Type of the second publisher.
        again: String,
    },
    /// The node has a subscription to this topic with another type.
    #[error(
        "the node subscribes to `{topic}` with the type `{declared}`; it was declared again with `{again}`"
    )]
    SubscribedOtherwise {
        /// Name of the topic.
        topic: String,
        /// Type of the first subscription.
        declared: String,
        /// Type of the second subscription.
        again: String,
    },
    /// The node provides this service.
    #[error(
        "the node already provides `{service}`, with the type `{declared}`; it was declared again with `{again}`"
    )]
    Served {
        /// Name of the service.
        service: String,
        /// Type of the first declaration.
        declared: String,
        /// Type of the second declaration.
        again: String,
    },
    /// The master does not answer, or refuses.
    #[error(
        "the ROS master {master} cannot be used: {reason}; is `roscore` running there, and is `ROS_MASTER_URI` right?"
    )]
    Master {
        /// Address of the master.
        master: String,
        /// Cause, for display.
        reason: String,
    },
    /// The system refuses a socket or a thread.
    #[error("cannot start the node: {0}")]
    System(String),
}
