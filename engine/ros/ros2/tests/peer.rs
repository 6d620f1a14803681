//! Peers: Cyclone DDS in Python, and nodes of this crate. Each test has a domain of its own, on the loopback interface alone.

use std::net::Ipv4Addr;
use std::time::{Duration, Instant};

use asmotion_datum::{Codec, Datum, Schema};
use asmotion_ros_interface::InterfaceName;
use asmotion_ros2::{Node, NodeOptions};

pub use asmotion_ros_domain::{
    LONG, Peer, action_kinds, catalogue, domain, hex, peer_script, python,
};

pub fn node(name: &str, domain: u16) -> Node {
    let options = NodeOptions {
        domain,
        networks: vec![Ipv4Addr::LOCALHOST.into()],
        ..NodeOptions::named(name)
    };
    Node::start(options, catalogue()).unwrap()
}

pub fn named(name: &str) -> InterfaceName {
    name.parse().unwrap()
}

pub fn json(value: &impl serde::Serialize) -> serde_json::Value {
    serde_json::to_value(value).unwrap()
}

/// Settings of a peer that publishes or subscribes.
pub fn topic_settings(domain: u16, topic: &str, of: &InterfaceName) -> serde_json::Value {
    let schema = catalogue().schema(of).unwrap();
    serde_json::json!({
        "domain": domain,
        "topic": format!("rt{topic}"),
        "type": format!("{}::msg::dds_::{}_", of.package(), of.name()),
        "schema": json(&schema),
    })
}

pub fn encode(message: &Datum, schema: &Schema) -> Vec<u8> {
    Codec::Cdr.encode(message, schema).unwrap()
}

pub fn text(content: &str) -> Datum {
    Datum::record([("data", Datum::text(content))])
}

/// Waits until a value is there.
pub fn wait<T>(what: &str, mut get: impl FnMut() -> Option<T>) -> T {
    let end = Instant::now() + LONG;
    loop {
        if let Some(found) = get() {
            return found;
        }
        assert!(Instant::now() < end, "no {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}
