//! What a proxy is told to do: plain data, checked by whoever reads composites.

use std::time::Duration;

use asmotion_datum::Schema;

use crate::condition::MessageCondition;
use crate::conversion::Conversion;

/// What a proxy does.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProxySettings {
    /// What it reads: outputs of the target.
    pub inputs: Vec<ProxyPort>,
    /// What it writes: inputs of the target.
    pub outputs: Vec<ProxyPort>,
    /// The operations that it serves.
    pub operations: Vec<Mapped>,
    /// Whom it tells what.
    pub notify: Option<ProxyNotification>,
}

/// A port, with the name that it has at the target.
#[derive(Clone, Debug, PartialEq)]
pub struct ProxyPort {
    /// Its name.
    pub name: String,
    /// What its messages look like, as the target declares them.
    pub message: Schema,
}

/// An operation that is a port.
#[derive(Clone, Debug, PartialEq)]
pub struct Mapped {
    /// The service it belongs to.
    pub service: String,
    /// The interface of the service.
    pub interface: String,
    /// Its name.
    pub operation: String,
    /// The port.
    pub port: String,
    /// How it uses the port.
    pub mode: ReplyMode,
    /// From argument to message, or from message to result.
    pub conversion: Conversion,
}

/// How an operation uses a port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReplyMode {
    /// It writes; a reply means that the sample is on its way.
    OneWay,
    /// It writes; a reply means that the target has taken the sample.
    Taken,
    /// It writes; a reply means that the motion has ended.
    Done,
    /// It reads the last sample.
    Last,
    /// It reads all samples since the last call.
    All,
}

/// Whom a proxy tells what.
#[derive(Clone, Debug, PartialEq)]
pub struct ProxyNotification {
    /// The reference it calls.
    pub reference: String,
    /// The interface of the reference.
    pub interface: String,
    /// The operation it calls.
    pub operation: String,
    /// From `{ event, detail }` to the argument of the operation.
    pub conversion: Conversion,
    /// Whether `busy` is told: a command was accepted.
    pub busy: bool,
    /// Whether and when `idle` is told: the motion has ended.
    pub idle: Option<IdleCriterion>,
    /// Whether and when `refresh` is told, sample by sample.
    pub refresh: Option<MessageCondition>,
    /// Whether and when `fault` is told, sample by sample.
    pub fault: Option<MessageCondition>,
    /// After how long without samples `stale` is told.
    pub stale: Option<Duration>,
}

/// A motion has ended when what is measured is near what was commanded, for some time.
#[derive(Clone, Debug, PartialEq)]
pub struct IdleCriterion {
    /// How near, each number.
    pub within: f64,
    /// Port and part of what was commanded.
    pub commanded: (String, String),
    /// Port and part of what is measured.
    pub measured: (String, String),
    /// For how long.
    pub held: Duration,
}
