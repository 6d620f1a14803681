//! Connections: how samples get from an output port to an input port (RTT `ConnPolicy`).

mod channel;
mod policy;
mod triple;

pub(crate) use channel::{Delivery, Receiver, Sender, Stamped, channel};
pub use policy::{Kind, OnStale, Policy};
