//! Syntactic model of a composite file: typed values with source locations, not yet checked.

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
    Busy, Component, Condition, Direction, Idle, Listed, MapEntry, MessagePath, Notify,
    PlannedIdle, PlannedNotify, PlannedPlot, PlannedProxyEntry, PlannedRosEntry, PlannedVerify,
    Plot, Ports, ProxyEntry, ProxyMode, Rename, RosEntry, Verify, Wanted,
};
pub use composite::{Composite, Head};
pub use deploy::{
    Deploy, PlannedProcess, PlannedRecord, PlannedRestart, Process, Record, Restart, RestartPolicy,
};
pub use endpoint::{
    Address, Bridge, BridgeKind, Broker, Gateway, PlannedBridge, PlannedBroker, PlannedGateway,
    PlannedReconnect, Reconnect, Tls,
};
pub use implementation::{BuiltinComponent, Implementation};
pub use pace::{Lifecycle, Pace, PlannedLifecycle, PlannedPace};
pub use promote::{Promoted, Promotion};
pub use setting::{Amount, Piece, Property, PropertyType, Scalar, Setting, Template};
pub use topic::{Outage, PlannedSending, Topic};
pub use wiring::{
    Cancel, Connection, ConnectionType, Delivery, End, PlannedPolicy, PlannedRetry, PlannedWire,
    Policy, Retry, Terminal, Transport, Wire,
};

/// Upper bound of all time settings in milliseconds: one day.
pub(crate) const DAY_MS: u64 = 86_400_000;

/// Timeout of a call in milliseconds if the wire has none.
pub const DEFAULT_TIMEOUT_MS: u64 = 1000;
