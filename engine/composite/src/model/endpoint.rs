//! Brokers, gateways and bridges.

use asmotion_datum::Codec;
use asmotion_derive::{Table, Word};

use super::limits::DAY_MS;
use crate::at::At;
use crate::template::Template;

/// A message broker.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a broker",
    example = "{ url = \"amqp://guest:guest@127.0.0.1:5672/%2f\" }",
    resolved = PlannedBroker
)]
pub struct Broker {
    /// Name in the composite.
    #[key(entry = thing, local)]
    pub name: At<String>,
    /// Broker URL including user and password.
    #[key(example = "\"amqp://guest:guest@127.0.0.1:5672/%2f\"", unresolved)]
    pub url: At<Template>,
    /// Topic exchange shared by the robots.
    #[key(example = "\"robots\"", default = "robots")]
    pub exchange: Option<At<String>>,
    /// Encoding of payloads.
    #[key(default)]
    pub codec: Option<At<Codec>>,
    /// Use of TLS.
    #[key(default)]
    pub tls: Option<At<Tls>>,
    /// Heartbeat interval; a peer is considered dead after two intervals without data.
    #[key(unit = "seconds", range = 2..=3600, default = 4)]
    pub heartbeat_s: Option<At<u64>>,
    /// Reconnection after a lost connection.
    #[key(default, example = "{ first_ms = 100, max_ms = 5000, jitter = 0.2 }")]
    pub reconnect: Option<Reconnect>,
}

/// Use of TLS on connections to a broker.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum Tls {
    /// Use TLS if the broker offers it.
    #[default]
    Prefer,
    /// Never use TLS.
    Off,
    /// Require TLS.
    Require,
}

/// Exponential backoff between connection attempts.
#[derive(Clone, Debug, Table)]
#[table(
    of = "`reconnect`",
    example = "{ first_ms = 100, max_ms = 5000, jitter = 0.2 }",
    resolved = PlannedReconnect
)]
pub struct Reconnect {
    /// Delay before the first attempt.
    #[key(unit = "milliseconds", range = 1..=DAY_MS, default = 100)]
    pub first_ms: Option<At<u64>>,
    /// Maximum delay.
    #[key(unit = "milliseconds", range = 1..=DAY_MS, default = 5000)]
    pub max_ms: Option<At<u64>>,
    /// Fraction of the delay that is random.
    #[key(range = 0.0..=1.0, default = 0.2)]
    pub jitter: Option<At<f64>>,
}

/// An HTTP gateway for promoted services.
#[derive(Clone, Debug, Table)]
#[table(of = "a gateway", example = "{ listen = \"127.0.0.1:8080\" }", resolved = PlannedGateway)]
pub struct Gateway {
    /// Name in the composite.
    #[key(entry = thing, local)]
    pub name: At<String>,
    /// Address and port to listen on; port 0 selects a free port.
    #[key(example = "\"127.0.0.1:8080\"", unresolved)]
    pub listen: At<Address>,
    /// Host names by which requests may address it, besides `localhost` and IP addresses.
    #[key(example = "\"rover1.local\"")]
    pub allowed_hosts: Vec<At<String>>,
    /// Secret that every request must present as `Authorization: Bearer TOKEN`.
    #[key(example = "\"${GATEWAY_TOKEN_FILE}\"")]
    pub token: Option<At<Template>>,
    /// Maximum number of simultaneous connections; a further one replaces the one that has been idle for the longest time.
    #[key(range = 1..=10_000, default = 64)]
    pub max_connections: Option<At<u64>>,
    /// Maximum size of a request body.
    #[key(unit = "kilobytes", range = 1..=1_000_000, default = 1000)]
    pub max_body_kb: Option<At<u64>>,
}

/// An address and a port; may contain substitutions.
#[derive(Clone, Debug, PartialEq)]
pub struct Address(pub Template);

/// A bridge to other middleware.
#[derive(Clone, Debug, Table)]
#[table(of = "a bridge", example = "{ kind = \"ros2\", domain = 0 }", resolved = PlannedBridge)]
pub struct Bridge {
    /// Name in the composite.
    #[key(entry = thing, local)]
    pub name: At<String>,
    /// Kind of middleware.
    #[key(example = "\"ros2\"")]
    pub kind: At<BridgeKind>,
    /// ROS 1: address of roscore.
    #[key(example = "\"http://127.0.0.1:11311\"")]
    pub master: Option<At<Template>>,
    /// ROS 2: domain ID; by default that of the environment variable `ROS_DOMAIN_ID`, or 0.
    #[key(range = 0..=232)]
    pub domain: Option<At<u64>>,
    /// rosbridge: address of the server.
    #[key(example = "\"ws://127.0.0.1:9090\"")]
    pub url: Option<At<Template>>,
    /// Node name in ROS, with its namespace. By default it consists of the names of the composite and of the component.
    #[key(example = "\"/composite_bridge\"")]
    pub node: Option<At<String>>,
    /// Topic of transforms, as for a robot whose nodes map `/tf` to `tf` in its namespace; a relative name is in the namespace of
    /// the node. Transforms that hold at all times are on the topic of this name with `_static`.
    #[key(default = "/tf", example = "\"tf\"")]
    pub transforms: Option<At<String>>,
    /// Folders with further definitions of messages, services and actions, relative to the composite: packages, a folder of
    /// packages, or an installed ROS.
    #[key(example = "[\"msgs\", \"/opt/ros/jazzy/share\"]")]
    pub definitions: Vec<At<String>>,
}

/// Middleware connected by a bridge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum BridgeKind {
    /// ROS 1 (TCPROS).
    #[default]
    Ros1,
    /// ROS 2 (DDS).
    Ros2,
    /// A rosbridge server.
    Rosbridge,
}
