//! Wires join a reference to services; connections join ports and topics.

use asmotion_component::{Lock, OnStale, Sharing};
use asmotion_derive::{Table, Word};
use asmotion_diagnostics::Span;

use super::{DAY_MS, DEFAULT_TIMEOUT_MS};
use crate::at::At;

/// `Component.name`: a port, a service, a reference or a property of a component.
#[derive(Clone, Debug, PartialEq)]
pub struct End {
    /// The component.
    pub component: At<String>,
    /// What of it.
    pub name: At<String>,
}

impl End {
    /// The place of both.
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
    /// `mqueue:/name`: a queue that an Orocos component of another process writes or reads.
    Mqueue(At<String>),
}

impl Terminal {
    /// Where it was written.
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

/// A reference and the services that answer it.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a wire",
    example = "{ reference = \"Coordinator.planner\", service = \"Planner.planning\" }",
    resolved = PlannedWire
)]
pub struct Wire {
    /// The place of the wire.
    pub span: Span,
    /// Reference of the component that calls.
    #[key(example = "\"Coordinator.planner\"")]
    pub reference: End,
    /// Service that answers; more than one for a fan-out of one-way calls.
    #[key(name = "service", needed, one, example = "\"Planner.planning\"")]
    pub services: Vec<End>,
    /// In which profiles; in all, if none is named.
    #[key(name = "profile", example = "\"sim\"", written)]
    pub profiles: Vec<At<String>>,
    /// What it goes over.
    #[key(default)]
    pub binding: Option<At<Transport>>,
    /// Over which broker, if there are several.
    #[key(example = "\"main\"")]
    pub broker: Option<At<String>>,
    /// How long the caller waits for each attempt.
    #[key(unit = "milliseconds", range = 1..=DAY_MS, default = DEFAULT_TIMEOUT_MS)]
    pub timeout_ms: Option<At<u64>>,
    /// How a call is tried again.
    #[key(default, example = "{ attempts = 2, backoff_ms = 100 }")]
    pub retry: Option<Retry>,
    /// What becomes of a call whose time is over.
    #[key(default)]
    pub cancel: Option<At<Cancel>>,
    /// Whether the caller waits for no reply.
    #[key(default)]
    pub oneway: Option<At<bool>>,
}

impl PlannedWire {
    /// Returns `true` if it goes over a broker even between components of one process.
    pub fn goes_abroad(&self) -> bool {
        self.binding == Transport::Amqp
    }
}

/// What a wire or a promotion goes over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum Transport {
    /// Within the process.
    #[default]
    Local,
    /// A broker.
    Amqp,
    /// ROS services.
    Ros,
    /// HTTP.
    Http,
}

/// What happens to a call nobody waits for any longer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum Cancel {
    /// It is withdrawn when its time is over.
    #[default]
    OnTimeout,
    /// It runs to its end.
    Never,
}

/// How a call is tried again.
#[derive(Clone, Debug, Table)]
#[table(of = "`retry`", example = "{ attempts = 2, backoff_ms = 100 }", resolved = PlannedRetry)]
pub struct Retry {
    /// How often after the first time.
    #[key(range = 0..=1000, default = 0)]
    pub attempts: Option<At<u64>>,
    /// Wait between two attempts.
    #[key(unit = "milliseconds", range = 0..=DAY_MS, default = 0)]
    pub backoff_ms: Option<At<u64>>,
}

/// From ports, topics or message queues to others: every writer is joined to every reader.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a connection",
    example = "{ from = \"Laser.scan\", to = \"Adapter.scan\" }"
)]
pub struct Connection {
    /// The place of the connection.
    pub span: Span,
    /// Writers: `Component.port`, `topic:name` or `mqueue:/name`.
    #[key(needed, one, example = "\"Laser.scan\"")]
    pub from: Vec<Terminal>,
    /// Readers, in the same form.
    #[key(needed, one, example = "\"topic:scan\"")]
    pub to: Vec<Terminal>,
    /// In which profiles; in all, if none is named.
    #[key(name = "profile", example = "\"sim\"", written)]
    pub profiles: Vec<At<String>>,
    /// How messages are carried.
    #[key(or_default, example = "{ type = \"data\" }")]
    pub policy: Policy,
}

impl Connection {
    /// Whether it joins a port of this component to a topic.
    pub fn joins_to_topic(&self, component: &str) -> bool {
        let own =
            |end: &Terminal| matches!(end, Terminal::Port(end) if end.component.value == component);
        let topic = |end: &Terminal| matches!(end, Terminal::Topic(_));
        let joins = |some: &[Terminal], others: &[Terminal]| {
            some.iter().any(own) && others.iter().any(topic)
        };
        joins(&self.from, &self.to) || joins(&self.to, &self.from)
    }
}

/// How a connection carries messages: RTT's connection policy, and what a reader does with old data.
#[derive(Clone, Debug, Default, Table)]
#[table(of = "a connection policy", example = "{ type = \"data\" }", resolved = PlannedPolicy)]
pub struct Policy {
    /// The place of the table.
    pub span: Span,
    /// The last value, or a queue.
    #[key(name = "type", default)]
    pub kind: Option<At<ConnectionType>>,
    /// Length of the queue.
    #[key(range = 1..=1_000_000, default = 1)]
    pub size: Option<At<u64>>,
    /// How writers and readers are kept apart.
    #[key(default)]
    pub lock: Option<At<Lock>>,
    /// Whether a new reader gets the last value written before.
    #[key(default)]
    pub init: Option<At<bool>>,
    /// Whether data stays with the writer until asked for.
    #[key(default)]
    pub pull: Option<At<bool>>,
    /// Whether a write that does not get through is an error of the writer.
    #[key(default)]
    pub mandatory: Option<At<bool>>,
    /// Which connections share the queue.
    #[key(default)]
    pub buffer: Option<At<Sharing>>,
    /// How many threads may use it; as many as there are ends, if absent.
    #[key(range = 1..=1024)]
    pub max_threads: Option<At<u64>>,
    /// How old data may be.
    #[key(unit = "milliseconds", range = 1..=DAY_MS)]
    pub max_age_ms: Option<At<u64>>,
    /// What a reader sees instead of data that is too old.
    #[key(default)]
    pub on_stale: Option<At<OnStale>>,
    /// Whether new data wakes the reader.
    #[key(default)]
    pub delivery: Option<At<Delivery>>,
    /// How often a polling reader looks.
    #[key(unit = "milliseconds", range = 1..=DAY_MS)]
    pub poll_ms: Option<At<u64>>,
    /// Size of the largest message in a queue `mqueue:/name`.
    #[key(unit = "bytes", range = 1..=16_777_216)]
    pub data_size: Option<At<u64>>,
}

/// Last value or queue.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum ConnectionType {
    /// The last value.
    #[default]
    Data,
    /// A queue; the newest is dropped when it is full.
    Buffer,
    /// A queue; the oldest is dropped when it is full.
    #[word("circular_buffer")]
    Circular,
}

/// Whether new data wakes the reader.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum Delivery {
    /// It does, if the reader is event-driven.
    #[default]
    Event,
    /// It does not: the reader reads when it cycles.
    Cycle,
    /// The reader looks every `poll_ms`.
    Poll,
}
