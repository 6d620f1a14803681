//! What joins the components of a plan.

use asmotion_composite::end::{End, Terminal};
use asmotion_composite::model::{PlannedPolicy, PlannedSending, Transport};

/// A topic.
#[derive(Clone, Debug, PartialEq)]
pub struct Topic {
    /// Its name.
    pub name: String,
    /// The type of its messages, if anybody says.
    pub kind: Option<String>,
    /// Whether the outside may publish and subscribe it.
    pub promoted: bool,
    /// How it goes over a broker; what is absent follows from the connections.
    pub sending: PlannedSending,
    /// The ports that publish it.
    pub publishers: Vec<End>,
    /// The ports that subscribe it.
    pub subscribers: Vec<End>,
}

/// A connection.
#[derive(Clone, Debug, PartialEq)]
pub struct Connection {
    /// Who writes.
    pub from: Terminal,
    /// Who reads.
    pub to: Terminal,
    /// How messages are carried.
    pub policy: PlannedPolicy,
    /// The queue that several connections share: their ends.
    pub queue: Option<String>,
}

/// Something that the outside sees.
#[derive(Clone, Debug, PartialEq)]
pub struct Promoted {
    /// `service`, `reference`, `property`, `port` or `topic`.
    pub what: &'static str,
    /// Its name outside.
    pub name: String,
    /// What it is inside: `Component.name`, or a topic.
    pub inside: String,
    /// Over what the outside reaches it.
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
