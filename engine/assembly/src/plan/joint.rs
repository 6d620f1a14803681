//! What joins the components of a plan.

use serde::{Serialize, Serializer};

use crate::model::{Cancel, Codec, Delivery, Flow, Lock, OnStale, Outage, Sharing, Transport};

/// The end of a connection or wire; shown as `Component.name`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct End {
    /// The component.
    pub component: String,
    /// Its port, service or reference.
    pub name: String,
}

/// One end of a connection; shown as `Component.port`, `topic:name` or `mqueue:/name`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Terminal {
    /// A port.
    Port(End),
    /// A topic.
    Topic(String),
    /// A message queue, beyond which there is an Orocos component.
    Mqueue(String),
}

/// A topic.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Topic {
    /// Its name.
    pub name: String,
    /// The type of its messages, if anybody says.
    #[serde(rename = "type")]
    pub kind: Option<String>,
    /// Whether the outside may publish and subscribe it.
    pub promoted: bool,
    /// Whether its messages are kept until a broker has confirmed them; else as the connections want it.
    pub confirm: Option<bool>,
    /// What becomes of them while the broker is away; else as the connections want it.
    pub outage: Option<Outage>,
    /// How many of them are kept then.
    pub size: Option<u64>,
    /// How they are encoded; else as the broker has it.
    pub codec: Option<Codec>,
    /// The ports that publish it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub publishers: Vec<End>,
    /// The ports that subscribe it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub subscribers: Vec<End>,
}

/// A connection.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Connection {
    /// Who writes.
    pub from: Terminal,
    /// Who reads.
    pub to: Terminal,
    /// How.
    pub policy: Policy,
}

/// How a connection carries messages.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Policy {
    /// Last value or queue.
    #[serde(rename = "type")]
    pub kind: Flow,
    /// Length of the queue; 1 for the last value.
    pub size: u64,
    /// How writers and readers are kept apart.
    pub lock: Lock,
    /// Whether a new reader gets the last value written before.
    pub init: bool,
    /// Whether data stays with the writer until asked for.
    pub pull: bool,
    /// Whether a write that does not get through is an error of the writer.
    pub mandatory: bool,
    /// Who shares the queue.
    pub buffer: Sharing,
    /// The queue that they share, if all of them do: the connection's ends.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub queue: Option<String>,
    /// How many threads may use it; as many as there are ends, if absent.
    pub max_threads: Option<u64>,
    /// Bytes of the largest message in a message queue.
    pub data_size: Option<u64>,
    /// How old data may be.
    pub max_age_ms: Option<u64>,
    /// What a reader sees instead of data that is too old.
    pub on_stale: OnStale,
    /// Whether new data wakes the reader.
    pub delivery: Delivery,
    /// How often a polling reader looks.
    pub poll_ms: Option<u64>,
}

/// A wire.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Wire {
    /// Who calls.
    pub reference: End,
    /// Who answers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub services: Vec<End>,
    /// The interface of both.
    pub interface: String,
    /// Over what.
    pub binding: Transport,
    /// Over which broker.
    pub broker: Option<String>,
    /// How long the caller waits.
    pub timeout_ms: u64,
    /// How often a call is tried again.
    pub retry_attempts: u64,
    /// How long to wait in between.
    pub retry_backoff_ms: u64,
    /// Whether a call that came too late is withdrawn.
    pub cancel: Cancel,
    /// Whether nobody waits for a reply.
    pub oneway: bool,
}

/// Something that the outside sees.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Promoted {
    /// `service`, `reference`, `property`, `port` or `topic`.
    pub what: &'static str,
    /// Its name outside.
    pub name: String,
    /// What it is inside: `Component.name`, or a topic.
    pub inside: String,
    /// Over what the outside reaches it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bindings: Vec<Transport>,
    /// Over which broker.
    pub broker: Option<String>,
    /// Through which gateway.
    pub gateway: Option<String>,
    /// How long a call through the gateway may take whose caller does not say.
    pub timeout_ms: Option<u64>,
}

impl Promoted {
    /// Whether it is a service that the outside reaches over this.
    pub fn is_served_over(&self, transport: Transport) -> bool {
        self.what == "service" && self.bindings.contains(&transport)
    }
}

impl std::fmt::Display for End {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}", self.component, self.name)
    }
}

impl Serialize for End {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl std::fmt::Display for Terminal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Port(end) => end.fmt(f),
            Self::Topic(topic) => write!(f, "topic:{topic}"),
            Self::Mqueue(name) => write!(f, "mqueue:{name}"),
        }
    }
}

impl Serialize for Terminal {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}
