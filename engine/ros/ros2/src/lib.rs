//! A node of ROS 2, with no ROS installed: topics, services, actions, the graph and simulated time, over DDS.
//!
//! Messages are [`Datum`](asmotion_datum::Datum)s that follow the schemas of a
//! [`Catalogue`](asmotion_ros_interface::Catalogue). A [`Node`] has one thread, which receives messages, decodes them and puts
//! them into bounded queues; sending and taking never wait. The README of the crate
//! lists the limits.
//!
//! ```no_run
//! use std::sync::Arc;
//! use asmotion_datum::Datum;
//! use asmotion_ros_interface::{Catalogue, Distribution};
//! use asmotion_ros2::{Node, NodeOptions, Qos};
//!
//! let catalogue = Arc::new(Catalogue::included(Distribution::Ros2));
//! let node = Node::start(NodeOptions::named("talker"), catalogue)?;
//! let text = "std_msgs/msg/String".parse()?;
//! let publisher = node.publisher("/chatter", &text, Qos::default())?;
//! publisher.send(&Datum::record([("data", Datum::text("hello"))]))?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod action;
mod clock;
mod deadline;
mod endpoint;
mod entities;
mod error;
mod gid;
mod graph;
mod history;
mod mapping;
mod names;
mod node;
mod notice;
mod outbox;
mod participant;
mod payload;
mod publisher;
mod qos;
mod queue;
mod reactor;
mod release;
mod scout;
mod service;
mod subscription;

pub use action::{ActionClient, ActionServer, Goal, GoalEvent, GoalId, GoalRequest, GoalStatus};
pub use clock::SimulatedClock;
pub use endpoint::{Endpoint, EndpointKind, RemoteNode};
pub use error::{CallError, EndpointError, NodeError, SendError};
pub use gid::Gid;
pub use graph::Graph;
pub use mapping::ServiceMapping;
pub use names::NameError;
pub use node::Node;
pub use notice::{Notice, Waker};
pub use outbox::PublisherCounts;
pub use participant::NodeOptions;
pub use publisher::Publisher;
pub use qos::{Durability, Qos, Reliability};
pub use service::{Call, Client, ClientCounts, ReplyTo, Request, Server, ServerCounts};
pub use subscription::{Received, Subscription, SubscriptionCounts, SubscriptionOptions};
