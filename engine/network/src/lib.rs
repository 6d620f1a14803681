//! Connects a system to buses, and through them to topics, ports and services of other processes.
//!
//! A [`Network`] collects the remote ends of a system: outputs read by other processes, services called by them, and
//! references to their services. [`Network::attach`] connects these and the system's topics to a bus, through an
//! adapter of the runtime. Components do not notice: a remote service is a queue of requests that the adapter empties.
//! [`Network::running`] joins further ends while the system runs.

mod adapter;
mod attachment;
mod error;
mod failure;
mod health;
mod identity;
mod network;
mod offered;
mod remote;
mod remote_ends;
mod robot_service;
mod running;
mod subscription;
mod topics;

pub use error::NetworkError;
pub use failure::call_error;
pub use network::Network;
pub use remote_ends::port_topic;
pub use robot_service::{AnnouncedOperation, AnnouncedService, RobotService};
pub use running::{KnownOperations, OuterCaller, OuterName, RunningNetwork};
pub use subscription::has_same_queue;
