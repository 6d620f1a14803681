//! Typed ports: samples frozen for a cycle, samples that wait for its commit, and the channels between.
//!
//! Components access their ports through the handles of `asmotion-component`; the runtime connects them through
//! [`AnyInput`] and [`AnyOutput`], which hide the message type. A [`Policy`] defines the guarantees of a connection,
//! and every sample carries the [`Time`] of its writer's cycle.

mod channel;
mod connection_id;
mod flow;
mod input;
mod loss_counter;
mod one_thread;
mod output;
mod policy;
mod queue_gauges;
mod sender;
mod snapshot;
mod time;

pub use asmotion_connection::{BufferKind, Notifier, PushOutcome, prefetch};
pub use channel::{ChannelOpener, OpenError, ReadingEnd, SharedQueue};
pub use connection_id::ConnectionId;
pub use flow::Flow;
pub use input::{AnyInput, InputPort, Refusals, TooOld};
pub use loss_counter::LossCounter;
pub use output::{
    AnyOutput, LinkReader, Notification, OutputLink, OutputPort, PortEffects, Undelivered,
};
pub use policy::{Lock, OnStale, Policy, Sharing};
pub use sender::{AnySender, PortSender, Stamped};
pub use snapshot::{InputSnapshot, OutputSnapshot, SampleSnapshot};
pub use time::{Span, Time};
