//! How topics go over a broker.

use asmotion_datum::Codec;
use asmotion_derive::{Table, Word};

use crate::at::At;

/// How a topic goes over a broker. What is left out follows from the connections.
#[derive(Clone, Debug, Table)]
#[table(of = "a topic", example = "{ confirm = true }", resolved = PlannedSending)]
pub struct Topic {
    /// The topic.
    #[key(entry = topic)]
    pub name: At<String>,
    /// Whether messages are kept until the broker has confirmed them, and sent again if need be.
    pub confirm: Option<At<bool>>,
    /// What becomes of messages while the broker is away.
    pub outage: Option<At<Outage>>,
    /// How many of them are kept.
    #[key(range = 1..=1_000_000)]
    pub size: Option<At<u64>>,
    /// How payloads are encoded; as the broker has it, if absent.
    pub codec: Option<At<Codec>>,
}

/// What becomes of messages while the broker is away.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum Outage {
    /// They are dropped, and counted.
    #[default]
    Drop,
    /// The newest is kept.
    Latest,
    /// The oldest so many are kept.
    Queue,
}
