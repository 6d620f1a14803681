//! Wires connect references to services; connections connect ports and topics.

use asmotion_component::{Lock, OnStale, Sharing};
use asmotion_derive::{Table, Word};
use asmotion_diagnostics::Span;

use super::instances::Instances;
use super::limits::{DAY_MS, DEFAULT_TIMEOUT_MS};
use crate::at::At;
use crate::template::Template;

/// `Component.name`: a port, a service, a reference or a property of a component.
#[derive(Clone, Debug, PartialEq)]
pub struct End {
    /// Component name.
    pub component: At<String>,
    /// Port, service, reference or property name.
    pub name: At<String>,
}

impl End {
    /// Source location of the whole end.
    pub fn span(&self) -> Span {
        self.component.span.to(self.name.span)
    }
}

impl std::fmt::Display for End {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}", self.component.value, self.name.value)
    }
}

/// One end of a connection.
#[derive(Clone, Debug, PartialEq)]
pub enum Terminal {
    /// A port of a component.
    Port(End),
    /// `topic:name`.
    Topic(At<String>),
    /// `mqueue:/name`: a queue shared with an Orocos component of another process.
    Mqueue(At<String>),
}

impl Terminal {
    /// Returns the source location.
    pub fn span(&self) -> Span {
        match self {
            Self::Port(end) => end.span(),
            Self::Topic(name) | Self::Mqueue(name) => name.span,
        }
    }
}

impl std::fmt::Display for Terminal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Port(end) => end.fmt(f),
            Self::Topic(topic) => write!(f, "topic:{}", topic.value),
            Self::Mqueue(name) => write!(f, "mqueue:{}", name.value),
        }
    }
}

/// A reference and the services it calls.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a wire",
    example = "{ reference = \"Coordinator.planner\", service = \"Planner.planning\" }",
    resolved = PlannedWire
)]
pub struct Wire {
    /// Source location of the wire.
    pub span: Span,
    /// Instances: one element for each value of a variable, which is substituted in its names and strings, as in
    /// `"R$r.scan"`. A string that is only the variable becomes its value.
    #[key(name = "for", example = "\"$r in 1..20\"", written)]
    pub instances: Option<Instances>,
    /// Reference of the calling component.
    #[key(example = "\"Coordinator.planner\"")]
    pub reference: End,
    /// Called service; several for a fan-out of one-way calls. `ros:/make_plan` is the service of a ros-bridge that is mapped to
    /// this service or action of ROS. A wire to another system or robot has a `url` instead.
    #[key(name = "service", one, example = "\"Planner.planning\"")]
    pub services: Vec<End>,
    /// Interface of the called service, in place of its name: the wire leads to the component that provides it.
    #[key(example = "\"nav/PlanService\"", written)]
    pub interface: Option<At<String>>,
    /// Service of another system, called over HTTP: operation `getMap` is `POST URL/getMap`. Over AMQP, service of another
    /// robot on the same broker: `robot://ROBOT/Component.service`.
    #[key(example = "\"http://127.0.0.1:8080/services/maps\"")]
    pub url: Option<At<Template>>,
    /// Secret that the calls over HTTP present as `Authorization: Bearer TOKEN`.
    #[key(example = "\"${MAPS_TOKEN_FILE}\"")]
    pub token: Option<At<Template>>,
    /// PEM file with the certificates of the authorities that an `https` server is trusted for, in place of the web's; relative
    /// to the folder of this file.
    #[key(example = "\"pki/plant-ca.pem\"")]
    pub ca: Option<At<String>>,
    /// Profiles that include it; all if empty.
    #[key(name = "profile", example = "\"sim\"", written)]
    pub profiles: Vec<At<String>>,
    /// Transport of the calls.
    #[key(default)]
    pub binding: Option<At<Transport>>,
    /// Broker; required if there are several.
    #[key(example = "\"main\"")]
    pub broker: Option<At<String>>,
    /// Time limit of each attempt.
    #[key(unit = "milliseconds", range = 1..=DAY_MS, default = DEFAULT_TIMEOUT_MS)]
    pub timeout_ms: Option<At<u64>>,
    /// Retries of failed calls.
    #[key(default, example = "{ attempts = 2, backoff_ms = 100 }")]
    pub retry: Option<Retry>,
    /// Handling of calls that have timed out.
    #[key(default)]
    pub cancel: Option<At<Cancel>>,
    /// Do not wait for a reply.
    #[key(default)]
    pub oneway: Option<At<bool>>,
}

impl PlannedWire {
    /// Returns `true` if the wire uses a broker even between components of the same process.
    pub fn goes_abroad(&self) -> bool {
        self.binding == Transport::Amqp
    }
}

/// Transport of a wire or promotion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum Transport {
    /// Within the process.
    #[default]
    Local,
    /// AMQP broker.
    Amqp,
    /// ROS services.
    Ros,
    /// HTTP.
    Http,
}

/// Handling of calls that have timed out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum Cancel {
    /// Cancel the call when it times out.
    #[default]
    OnTimeout,
    /// Let the call complete.
    Never,
}

/// Retries of failed calls.
#[derive(Clone, Debug, Table)]
#[table(of = "`retry`", example = "{ attempts = 2, backoff_ms = 100 }", resolved = PlannedRetry)]
pub struct Retry {
    /// Number of retries after the first attempt.
    #[key(range = 0..=1000, default = 0)]
    pub attempts: Option<At<u64>>,
    /// Delay between two attempts.
    #[key(unit = "milliseconds", range = 0..=DAY_MS, default = 0)]
    pub backoff_ms: Option<At<u64>>,
}

/// A connection between ports, topics or message queues: every writer is connected to every reader.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a connection",
    example = "{ from = \"Laser.scan\", to = \"Adapter.scan\" }"
)]
pub struct Connection {
    /// Source location of the connection.
    pub span: Span,
    /// Instances: one element for each value of a variable, which is substituted in its names and strings, as in
    /// `"R$r.scan"`. A string that is only the variable becomes its value.
    #[key(name = "for", example = "\"$r in 1..20\"")]
    pub instances: Option<Instances>,
    /// Writers: `Component.port`, `topic:name` or `mqueue:/name`.
    #[key(needed, one, example = "\"Laser.scan\"")]
    pub from: Vec<Terminal>,
    /// Readers, in the same form.
    #[key(needed, one, example = "\"topic:scan\"")]
    pub to: Vec<Terminal>,
    /// Profiles that include it; all if empty.
    #[key(name = "profile", example = "\"sim\"", written)]
    pub profiles: Vec<At<String>>,
    /// Transfer policy of the connection.
    #[key(or_default, example = "{ type = \"data\" }")]
    pub policy: Policy,
}

/// Transfer policy of a connection: RTT's connection policy, extended by the handling of stale data.
#[derive(Clone, Debug, Default, Table)]
#[table(of = "a connection policy", example = "{ type = \"data\" }", resolved = PlannedPolicy)]
pub struct Policy {
    /// Source location of the table.
    pub span: Span,
    /// Storage: the last value or a queue.
    #[key(name = "type", default)]
    pub kind: Option<At<ConnectionType>>,
    /// Capacity of the queue.
    #[key(range = 1..=1_000_000, default = 1)]
    pub size: Option<At<u64>>,
    /// Synchronisation of writers and readers.
    #[key(default)]
    pub lock: Option<At<Lock>>,
    /// Deliver the last written value to new readers.
    #[key(default)]
    pub init: Option<At<bool>>,
    /// Keep data with the writer until the reader requests it.
    #[key(default)]
    pub pull: Option<At<bool>>,
    /// Report a failed write to the writer as an error.
    #[key(default)]
    pub mandatory: Option<At<bool>>,
    /// Sharing of the queue among connections.
    #[key(default)]
    pub buffer: Option<At<Sharing>>,
    /// Maximum number of threads using the connection; one per end by default.
    #[key(range = 1..=1024)]
    pub max_threads: Option<At<u64>>,
    /// Age after which a message is stale.
    #[key(unit = "milliseconds", range = 1..=DAY_MS)]
    pub max_age_ms: Option<At<u64>>,
    /// Stale messages: used all the same, or discarded and counted, and the reader has no data or reads zeros once.
    #[key(default)]
    pub on_stale: Option<At<OnStale>>,
    /// Notification of the reader about new data.
    #[key(default)]
    pub delivery: Option<At<Delivery>>,
    /// Interval at which a polling reader checks for data.
    #[key(unit = "milliseconds", range = 1..=DAY_MS)]
    pub poll_ms: Option<At<u64>>,
    /// Size of the largest message in a queue `mqueue:/name`.
    #[key(unit = "bytes", range = 1..=16_777_216)]
    pub data_size: Option<At<u64>>,
}

/// Storage of a connection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum ConnectionType {
    /// The last value.
    #[default]
    Data,
    /// A queue that rejects new messages when full.
    Buffer,
    /// A queue that overwrites the oldest message when full.
    #[word("circular_buffer")]
    Circular,
}

/// Notification of the reader about new data.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum Delivery {
    /// Wake an event-driven reader.
    #[default]
    Event,
    /// No notification; data is read in the reader's next cycle.
    Cycle,
    /// The reader checks every `poll_ms`.
    Poll,
}
