//! A node of ROS 1: topics, services and parameters, with no ROS installed.
//!
//! [`RosNode`] has the interface of a bus (`asmotion-bus`): a publisher puts a message into bounded outboxes, a subscription is
//! a bounded queue, and a call ends at its deadline. Tasks on threads of the node do the input and output, so no cycle waits
//! for the network. Messages are [`Datum`](asmotion_datum::Datum), with the schemas of `asmotion-ros-interface`.
//!
//! ```no_run
//! use asmotion_ros1::{RosNode, RosSettings, TopicType};
//! use asmotion_ros_interface::{Catalogue, Distribution};
//!
//! let noetic = Catalogue::included(Distribution::Ros1);
//! let text = TopicType::of(&noetic, &"std_msgs/String".parse()?)?;
//! let node = RosNode::start(RosSettings::new("/talker"))?;
//! let chatter = node.publisher("chatter", text, 10, false)?;
//! chatter.publish(&asmotion_datum::Datum::record([("data", asmotion_datum::Datum::text("hello"))]))?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod action;
mod caller;
mod circle;
mod clock;
mod context;
mod error;
mod frame;
mod graph;
pub mod header;
mod http;
mod interface;
mod names;
mod node;
mod notice;
mod parameter;
mod provider;
mod publication;
mod reader;
mod registrar;
mod relays;
mod server;
mod settings;
mod slave;
mod subscription;
mod tables;
mod time;
pub mod xmlrpc;

pub use action::{
    ActionClient, ActionClientCounts, ActionError, ActionEvent, ActionRequest, ActionServer,
    ActionType, ActionTypeError, GoalId, GoalOutcome, GoalPhase, ServedGoalError,
};
pub use caller::{DIED, FAILED, MISMATCH, RosServiceClient, UNREADABLE};
pub use clock::{RosClock, clock_message};
pub use error::RosError;
pub use graph::{RosGraph, RosTopic};
pub use http::{RosUri, RosUriError};
pub use interface::{ServiceType, TopicType};
pub use names::{RosName, RosNameError};
pub use node::{RosNode, RosPublisher};
pub use notice::{RosNotice, StatedType, TypeMismatch};
pub use publication::{RosPublisherCounts, SubscriberCounts};
pub use settings::{RosLimits, RosSettings, RosTiming};
pub use subscription::{RosSubscriptionCounts, UnreadableMessages};
