//! The settings of a proxy: plain data, checked by the reader of composites.

use std::time::Duration;

use asmotion_component::declaration::OperationDeclaration;
use asmotion_datum::Schema;

use crate::condition::MessageCondition;
use crate::conversion::Conversion;

/// The settings of a proxy.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProxySettings {
    /// Names of the components that handle its messages: the target, or the connected components inside a nested composite.
    pub targets: Vec<String>,
    /// Outputs of the target, which the proxy reads.
    pub inputs: Vec<ProxyPort>,
    /// Inputs of the target, which the proxy writes.
    pub outputs: Vec<ProxyPort>,
    /// The operations that the proxy provides.
    pub operations: Vec<Mapped>,
    /// Lists of commands, and the lists of the target's state that have as many elements.
    pub lengths: Vec<ListLength>,
    /// The events that it sends, and their receiver; `None` for no events.
    pub notify: Option<ProxyNotification>,
}

/// A port of the target.
#[derive(Clone, Debug, PartialEq)]
pub struct ProxyPort {
    /// Name of the port at the target.
    pub name: String,
    /// Schema of its messages, as declared by the target.
    pub message: Schema,
}

/// A list of a command that must have as many elements as a list of the target's state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ListLength {
    /// Port and path of the list in commands.
    pub commanded: (String, String),
    /// Port and path of the list in the target's state.
    pub measured: (String, String),
    /// Number of elements, if the type of the state declares it; otherwise it is learnt from samples.
    pub declared: Option<usize>,
}

/// An operation that is mapped to a port.
#[derive(Clone, Debug, PartialEq)]
pub struct Mapped {
    /// Name of the service that contains the operation.
    pub service: String,
    /// Interface of the service.
    pub interface: String,
    /// The operation; without types if the interface is unknown.
    pub operation: OperationDeclaration,
    /// Name of the target's port.
    pub port: String,
    /// Use of the port, and meaning of a reply.
    pub mode: ReplyMode,
    /// Conversion from the request to the message, or from the message to the response.
    pub conversion: Conversion,
}

/// The use of a port by an operation, and the meaning of a reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReplyMode {
    /// Writes; the reply means that the sample was written.
    OneWay,
    /// Writes; the reply means that the target has consumed the sample.
    Taken,
    /// Writes; the reply means that the motion has ended.
    Done,
    /// Reads the newest sample.
    Last,
    /// Reads all samples since the last call.
    All,
}

/// The events that a proxy sends, and their receiver.
#[derive(Clone, Debug, PartialEq)]
pub struct ProxyNotification {
    /// Name of the reference that the events are sent through.
    pub reference: String,
    /// Interface of the reference.
    pub interface: String,
    /// Name of the operation that is called for each event.
    pub operation: String,
    /// Conversion from `{ event, detail }` to the operation's request.
    pub conversion: Conversion,
    /// Send `busy` when a command is accepted.
    pub busy: bool,
    /// Condition for sending `idle`: the motion has ended. `None` for never.
    pub idle: Option<IdleCriterion>,
    /// Samples to report as `refresh`. `None` for no samples.
    pub refresh: Option<MessageCondition>,
    /// Samples to report as `fault`. `None` for no samples.
    pub fault: Option<MessageCondition>,
    /// Time without samples after which `stale` is sent. `None` for never.
    pub stale: Option<Duration>,
}

/// Criterion for the end of a motion: the measured values are near the commanded ones for some time.
#[derive(Clone, Debug, PartialEq)]
pub struct IdleCriterion {
    /// Greatest difference between a measured and a commanded value.
    pub within: f64,
    /// Port and path of the commanded values.
    pub commanded: (String, String),
    /// Port and path of the measured values.
    pub measured: (String, String),
    /// Minimum time for which the values must be near.
    pub settle_time: Duration,
}
