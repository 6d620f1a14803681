//! Brokers, gateways and bridges: where messages leave the process.

use asmotion_datum::Codec;
use asmotion_derive::{Table, Word};

use super::{DAY_MS, Template};
use crate::at::At;

/// A message broker.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a broker",
    example = "{ url = \"amqp://guest:guest@127.0.0.1:5672/%2f\" }",
    resolved = PlannedBroker
)]
pub struct Broker {
    /// Its name in the composite.
    #[key(entry = thing, local)]
    pub name: At<String>,
    /// Its address, with user and password.
    #[key(example = "\"amqp://guest:guest@127.0.0.1:5672/%2f\"", unresolved)]
    pub url: At<Template>,
    /// The topic exchange, which robots share.
    #[key(example = "\"robots\"", default = "robots")]
    pub exchange: Option<At<String>>,
    /// How payloads are encoded.
    #[key(default)]
    pub codec: Option<At<Codec>>,
    /// Whether the line is encrypted.
    #[key(default)]
    pub tls: Option<At<Tls>>,
    /// How often each side shows that it is alive; a dead peer is noticed after twice that.
    #[key(unit = "seconds", range = 2..=3600, default = 4)]
    pub heartbeat_s: Option<At<u64>>,
    /// How a lost connection is made again.
    #[key(default, example = "{ first_ms = 100, max_ms = 5000, jitter = 0.2 }")]
    pub reconnect: Option<Reconnect>,
}

/// Whether the line to a broker is encrypted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum Tls {
    /// Where the broker offers it.
    #[default]
    Prefer,
    /// Never.
    Off,
    /// Always.
    Require,
}

/// How a lost connection is made again: waits double from the first to the longest.
#[derive(Clone, Debug, Table)]
#[table(
    of = "`reconnect`",
    example = "{ first_ms = 100, max_ms = 5000, jitter = 0.2 }",
    resolved = PlannedReconnect
)]
pub struct Reconnect {
    /// First wait.
    #[key(unit = "milliseconds", range = 1..=DAY_MS, default = 100)]
    pub first_ms: Option<At<u64>>,
    /// Longest wait.
    #[key(unit = "milliseconds", range = 1..=DAY_MS, default = 5000)]
    pub max_ms: Option<At<u64>>,
    /// Share of the wait that is random.
    #[key(range = 0.0..=1.0, default = 0.2)]
    pub jitter: Option<At<f64>>,
}

/// Where promoted services are called over HTTP.
#[derive(Clone, Debug, Table)]
#[table(of = "a gateway", example = "{ listen = \"127.0.0.1:8080\" }", resolved = PlannedGateway)]
pub struct Gateway {
    /// Its name in the composite.
    #[key(entry = thing, local)]
    pub name: At<String>,
    /// Address and port it listens at; port 0 is a free one.
    #[key(example = "\"127.0.0.1:8080\"", unresolved)]
    pub listen: At<Address>,
    /// How many may be connected at once.
    #[key(range = 1..=10_000, default = 64)]
    pub max_connections: Option<At<u64>>,
    /// The longest argument of a call.
    #[key(unit = "thousands of bytes", range = 1..=1_000_000, default = 1000)]
    pub max_body_kb: Option<At<u64>>,
}

/// An address and a port, in which something may be substituted.
#[derive(Clone, Debug, PartialEq)]
pub struct Address(pub Template);

/// A way to another middleware.
#[derive(Clone, Debug, Table)]
#[table(of = "a bridge", example = "{ kind = \"ros2\", domain = 0 }", resolved = PlannedBridge)]
pub struct Bridge {
    /// Its name in the composite.
    #[key(entry = thing, local)]
    pub name: At<String>,
    /// Which middleware.
    #[key(example = "\"ros2\"")]
    pub kind: At<BridgeKind>,
    /// ROS 1: address of roscore.
    #[key(example = "\"http://127.0.0.1:11311\"")]
    pub master: Option<At<Template>>,
    /// ROS 2: the domain.
    #[key(range = 0..=232)]
    pub domain: Option<At<u64>>,
    /// rosbridge: address of the server.
    #[key(example = "\"ws://127.0.0.1:9090\"")]
    pub url: Option<At<Template>>,
    /// The name under which we appear there.
    #[key(example = "\"/composite_bridge\"")]
    pub node: Option<At<String>>,
}

/// The middleware on the other side of a bridge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum BridgeKind {
    /// ROS 1, by its own wire.
    #[default]
    Ros1,
    /// ROS 2, by DDS.
    Ros2,
    /// A rosbridge server.
    Rosbridge,
}
