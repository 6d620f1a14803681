//! Wires join a reference to services; connections join ports and topics.

use asmotion_component::{Lock, OnStale, Sharing};
use asmotion_derive::Word;
use asmotion_diagnostics::Span;

use crate::At;

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

/// `[[wires]]`: a reference and the services that answer it.
#[derive(Clone, Debug)]
pub struct Wire {
    /// The place of the wire.
    pub span: Span,
    /// In which profiles; everywhere where empty.
    pub profiles: Vec<At<String>>,
    /// Who calls.
    pub reference: End,
    /// Who answers; more than one for a fan-out of one-way calls.
    pub services: Vec<End>,
    /// Over what.
    pub binding: Option<At<Transport>>,
    /// Over which broker, if there are several.
    pub broker: Option<At<String>>,
    /// How long the caller waits.
    pub timeout_ms: Option<At<i64>>,
    /// How often a call is tried again.
    pub retry: Option<Retry>,
    /// Whether a call that came too late is withdrawn.
    pub cancel: Option<At<Cancel>>,
    /// Whether nobody waits for a reply.
    pub oneway: Option<At<bool>>,
}

/// What a wire or a promotion goes over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, Word)]
#[serde(rename_all = "snake_case")]
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
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum Cancel {
    /// It is withdrawn when its time is over.
    #[default]
    OnTimeout,
    /// It runs to its end.
    Never,
}

/// `retry`: how often a call is tried again.
#[derive(Clone, Debug)]
pub struct Retry {
    /// How often after the first time.
    pub attempts: Option<At<i64>>,
    /// How long to wait in between.
    pub backoff_ms: Option<At<i64>>,
}

/// `[[connections]]`: from ports or topics to ports or topics.
#[derive(Clone, Debug)]
pub struct Connection {
    /// The place of the connection.
    pub span: Span,
    /// In which profiles; everywhere where empty.
    pub profiles: Vec<At<String>>,
    /// Who writes.
    pub from: Vec<Terminal>,
    /// Who reads.
    pub to: Vec<Terminal>,
    /// How.
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

/// `policy`: RTT's connection policy, and what a reader does with old data.
#[derive(Clone, Debug, Default)]
pub struct Policy {
    /// The place of the table.
    pub span: Span,
    /// Last value or queue.
    pub kind: Option<At<Flow>>,
    /// Length of the queue.
    pub size: Option<At<i64>>,
    /// How writers and readers are kept apart.
    pub lock: Option<At<Lock>>,
    /// Whether a new reader gets the last value written before.
    pub init: Option<At<bool>>,
    /// Whether data stays with the writer until asked for.
    pub pull: Option<At<bool>>,
    /// Whether a write that does not get through is an error of the writer.
    pub mandatory: Option<At<bool>>,
    /// Who shares the queue.
    pub buffer: Option<At<Sharing>>,
    /// How many threads may use a connection.
    pub max_threads: Option<At<i64>>,
    /// Bytes of the largest message in a queue `mqueue:/name`.
    pub data_size: Option<At<i64>>,
    /// How old data may be.
    pub max_age_ms: Option<At<i64>>,
    /// What a reader sees instead of data that is too old.
    pub on_stale: Option<At<OnStale>>,
    /// Whether new data wakes the reader.
    pub delivery: Option<At<Delivery>>,
    /// How often a polling reader looks.
    pub poll_ms: Option<At<i64>>,
}

/// Last value or queue.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum Flow {
    /// The last value.
    #[default]
    Data,
    /// A queue; the newest is dropped when it is full.
    Buffer,
    /// A queue; the oldest is dropped when it is full.
    #[word("circular_buffer")]
    #[serde(rename = "circular_buffer")]
    Circular,
}

/// Whether new data wakes the reader.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum Delivery {
    /// It does, if the reader is event-driven.
    #[default]
    Event,
    /// It does not: the reader reads when it cycles.
    Cycle,
    /// The reader looks every `poll_ms`.
    Poll,
}
