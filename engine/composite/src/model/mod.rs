//! Syntactic model of a composite file: typed values with source locations, not yet checked.

pub mod binding;
mod binding_value;
mod component;
mod component_brokers;
mod component_reader;
mod composite;
mod deploy;
mod end_text;
mod endpoint;
mod implementation;
mod instances;
mod limits;
mod pace;
mod promote;
mod setting;
mod topic;
mod value;
mod wiring;

pub use crate::template::{Piece, Template};
pub use asmotion_component::{
    Lock, OnDeadline, OnException, OnStale, Overrun, Scheduler, Sharing, ThreadUse,
};
pub use asmotion_datum::Codec;
pub use component::{
    Busy, Component, Condition, Direction, Durability, FrameTransform, Idle, ListLength, Listed,
    MapEntry, MessagePath, Notify, PlannedFrameTransform, PlannedIdle, PlannedListLength,
    PlannedMapEntry, PlannedNotify, PlannedPlot, PlannedProxyEntry, PlannedRosEntry, PlannedRosQos,
    PlannedSpecialKeys, PlannedStatedProperty, PlannedVerify, PlannedWatch, Plot, Ports,
    ProxyEntry, ProxyMode, Rename, RosEntry, RosQos, RosReliability, SpecialKeys, StatedProperty,
    Verify, Wanted, Watch,
};
pub use component_brokers::ComponentBrokers;
pub use composite::{Composite, Head};
pub use deploy::{
    Deploy, PlannedProcess, PlannedRecord, PlannedRestart, Process, Record, RecordReaders, Restart,
    RestartPolicy,
};
pub(crate) use end_text::ROS;
pub use endpoint::{
    Address, Bridge, BridgeKind, Broker, Gateway, PlannedBridge, PlannedBroker, PlannedGateway,
    PlannedReconnect, Reconnect, Tls,
};
pub use implementation::{BuiltinComponent, Implementation, PlannedImplementation};
pub use instances::Instances;
pub use limits::DEFAULT_TIMEOUT_MS;
pub use pace::{Lifecycle, Pace, PlannedLifecycle, PlannedPace};
pub use promote::{Promoted, Promotion};
pub use setting::{Amount, Property, PropertyType, Scalar, Setting};
pub use topic::{Outage, PlannedSending, Topic};
pub use wiring::{
    Cancel, Connection, ConnectionType, Delivery, End, PlannedPolicy, PlannedRetry, PlannedWire,
    Policy, Retry, Terminal, Transport, Wire,
};
