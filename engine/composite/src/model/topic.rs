//! Settings of topics sent over a broker.

use asmotion_datum::Codec;
use asmotion_derive::{Table, Word};

use super::instances::Instances;
use crate::at::At;

/// Settings of a topic sent over a broker. Omitted keys are derived from the connections.
#[derive(Clone, Debug, Table)]
#[table(of = "a topic", example = "{ confirm = true }", resolved = PlannedSending)]
pub struct Topic {
    /// Name of the topic.
    #[key(entry = topic)]
    pub name: At<String>,
    /// Instances: one element for each value of a variable, which is substituted in its names and strings, as in
    /// `"R$r.scan"`. A string that is only the variable becomes its value.
    #[key(name = "for", example = "\"$r in 1..20\"", written)]
    pub instances: Option<Instances>,
    /// Keep messages until the broker has confirmed them and resend them if necessary.
    pub confirm: Option<At<bool>>,
    /// Handling of messages while the broker is unreachable.
    pub outage: Option<At<Outage>>,
    /// Maximum number of messages kept.
    #[key(range = 1..=1_000_000)]
    pub size: Option<At<u64>>,
    /// Encoding of payloads; that of the broker by default.
    pub codec: Option<At<Codec>>,
}

/// Handling of messages while the broker is unreachable.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum Outage {
    /// Drop messages and count them.
    #[default]
    Drop,
    /// Keep the newest message.
    Latest,
    /// Keep the oldest `size` messages.
    Queue,
}
