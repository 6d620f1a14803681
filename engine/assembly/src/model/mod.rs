//! A composite file as it was written: typed, every value with its place, nothing judged yet.

pub mod binding;
mod component;
mod composite;
mod deploy;
mod endpoint;
mod implementation;
mod pace;
mod promote;
mod setting;
mod topic;
mod wiring;

pub use asmotion_component::{Lock, OnDeadline, OnException, OnStale, Overrun, Scheduler, Sharing};
pub use asmotion_datum::Codec;
pub use component::{
    Busy, Component, Condition, Direction, Idle, Listed, MapEntry, Notify, Path, Plot, ProxyEntry,
    ProxyMode, Rename, RosEntry, Verify, Wanted,
};
pub use composite::Composite;
pub use deploy::{Deploy, Process, Record, Restart, RestartPolicy};
pub use endpoint::{Bridge, BridgeKind, Broker, Gateway, Reconnect, Tls};
pub use implementation::{Builtin, Implementation};
pub use pace::{Lifecycle, Pace};
pub use promote::{Promoted, Promotion};
pub use setting::{Amount, Piece, Property, PropertyType, Scalar, Setting, Template};
pub use topic::{Outage, Topic};
pub use wiring::{
    Cancel, Connection, Delivery, End, Flow, Policy, Retry, Terminal, Transport, Wire,
};
