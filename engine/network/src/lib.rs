//! Joins a system to buses: topics, ports and services of other processes.
//!
//! A [`Network`] collects what of a system is remote: outputs that inputs of other processes read, services that others
//! call, references to services of others. [`Network::attach`] joins all of it, and the system's topics, to a bus by an
//! adapter of the runtime. To a component nothing of that shows: a remote service is a queue that the adapter empties.

mod adapter;
mod attachment;
mod ends;
mod error;
mod failure;
mod health;
mod identity;
mod network;
mod offered;
mod remote;
mod subscription;
mod topics;

pub use ends::port_topic;
pub use error::NetworkError;
pub use failure::call_error;
pub use network::Network;
