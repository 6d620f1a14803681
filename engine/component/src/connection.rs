//! Connections: how samples get from an output port to an input port (RTT `ConnPolicy`).

mod channel;
mod policy;
mod triple;

pub use channel::Delivery;
pub(crate) use channel::{Receiver, Sender, Stamped, channel};
pub use policy::{Kind, OnStale, Policy};
