//! How topics go over a broker.

use crate::At;
use asmotion_datum::Codec;
use asmotion_derive::Word;

/// `[topics.<name>]`. What is left out follows from the connections.
#[derive(Clone, Debug)]
pub struct Topic {
    /// The topic.
    pub name: At<String>,
    /// Whether messages are kept until the broker has confirmed them, and sent again if need be.
    pub confirm: Option<At<bool>>,
    /// What becomes of messages while the broker is away.
    pub outage: Option<At<Outage>>,
    /// How many of them are kept.
    pub size: Option<At<i64>>,
    /// How payloads are encoded; as the broker has it where not given.
    pub codec: Option<At<Codec>>,
}

/// What becomes of messages while the broker is away.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum Outage {
    /// They are dropped, and counted.
    #[default]
    Drop,
    /// The newest is kept.
    Latest,
    /// The oldest so many are kept.
    Queue,
}
