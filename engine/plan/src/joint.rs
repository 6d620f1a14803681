//! Topics, connections and promotions of a plan.

use asmotion_composite::end::{End, Terminal};
use asmotion_composite::model::{PlannedPolicy, PlannedSending, Transport};

/// A topic of the system.
#[derive(Clone, Debug, PartialEq)]
pub struct Topic {
    /// Name, qualified by the enclosing composites unless promoted.
    pub name: String,
    /// Message type name; `None` if unknown.
    pub kind: Option<String>,
    /// Whether clients outside the system may publish and subscribe.
    pub promoted: bool,
    /// Settings for sending over a broker; absent ones are derived from the connections.
    pub sending: PlannedSending,
    /// Ports that publish to the topic.
    pub publishers: Vec<End>,
    /// Ports that subscribe to the topic.
    pub subscribers: Vec<End>,
}

/// A connection between one writer and one reader.
#[derive(Clone, Debug, PartialEq)]
pub struct Connection {
    /// Writing end.
    pub from: Terminal,
    /// Reading end.
    pub to: Terminal,
    /// Transfer policy.
    pub policy: PlannedPolicy,
    /// Identifier of the queue shared by several connections, formed from their ends; `None` if not shared.
    pub queue: Option<String>,
}

/// An element visible outside the system.
#[derive(Clone, Debug, PartialEq)]
pub struct Promoted {
    /// `service`, `reference`, `property`, `port` or `topic`.
    pub what: &'static str,
    /// Public name.
    pub name: String,
    /// Promoted element: `Component.name` or a topic.
    pub inside: String,
    /// Transports for access from outside.
    pub bindings: Vec<Transport>,
    /// Broker name; `None` for the default broker.
    pub broker: Option<String>,
    /// Gateway name; `None` if not accessible over HTTP.
    pub gateway: Option<String>,
    /// Default timeout in milliseconds of calls through the gateway.
    pub timeout_ms: Option<u64>,
}

impl Promoted {
    /// Returns whether it is a service accessible over this transport.
    pub fn is_served_over(&self, transport: Transport) -> bool {
        self.what == "service" && self.bindings.contains(&transport)
    }
}
