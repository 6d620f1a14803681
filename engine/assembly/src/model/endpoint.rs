//! Brokers, gateways and bridges: where messages leave the process.

use super::Template;
use crate::At;
use asmotion_datum::Codec;
use asmotion_derive::Word;

/// A message broker.
#[derive(Clone, Debug)]
pub struct Broker {
    /// Its name in the composite.
    pub name: At<String>,
    /// Where it is, with user and password.
    pub url: At<Template>,
    /// The topic exchange; `robots` where not given.
    pub exchange: Option<At<String>>,
    /// How payloads are encoded.
    pub codec: Option<At<Codec>>,
    /// Whether the line is encrypted.
    pub tls: Option<At<Tls>>,
    /// How a lost connection is taken up again.
    pub reconnect: Option<Reconnect>,
}

/// Whether the line to a broker is encrypted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum Tls {
    /// Where the broker offers it.
    #[default]
    Prefer,
    /// Never.
    Off,
    /// Always.
    Require,
}

/// How a lost connection is taken up again: waits double from first to max.
#[derive(Clone, Debug)]
pub struct Reconnect {
    /// First wait.
    pub first_ms: Option<At<i64>>,
    /// Longest wait.
    pub max_ms: Option<At<i64>>,
    /// Share of the wait that is random.
    pub jitter: Option<At<f64>>,
}

/// Where services are called over HTTP.
#[derive(Clone, Debug)]
pub struct Gateway {
    /// Its name in the composite.
    pub name: At<String>,
    /// Where it listens: an address and a port.
    pub listen: At<Template>,
    /// How many may be connected at once.
    pub max_connections: Option<At<i64>>,
    /// The longest argument, in thousands of bytes.
    pub max_body_kb: Option<At<i64>>,
}

/// A way to another middleware.
#[derive(Clone, Debug)]
pub struct Bridge {
    /// Its name in the composite.
    pub name: At<String>,
    /// Which middleware.
    pub kind: At<BridgeKind>,
    /// ROS 1: where roscore is.
    pub master: Option<At<Template>>,
    /// ROS 2: the domain.
    pub domain: Option<At<i64>>,
    /// rosbridge: where the server is.
    pub url: Option<At<Template>>,
    /// The name under which we appear there.
    pub node: Option<At<String>>,
}

/// The middleware on the other side of a bridge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum BridgeKind {
    /// ROS 1, by its own wire.
    #[default]
    Ros1,
    /// ROS 2, by DDS.
    Ros2,
    /// A rosbridge server.
    Rosbridge,
}
