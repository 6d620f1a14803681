//! Brokers, gateways and bridges.

use super::keys::{Keys, Reader};
use super::name;
use crate::At;
use crate::model::{Bridge, Broker, Gateway, Reconnect};
use crate::tree::Node;

/// No wait is longer than a day.
pub(crate) const DAY_MS: i64 = 86_400_000;

pub(crate) fn broker(reader: &mut Reader<'_>, key: &At<String>, node: &Node) -> Option<Broker> {
    let name = name::thing(reader, key)?;
    let url = "\"amqp://guest:guest@127.0.0.1:5672/%2f\"";
    let mut keys = reader.keys_of(node, key, "a broker", &format!("{{ url = {url} }}"))?;
    keys.need("url", url);
    let address = keys.template("url", url);
    let exchange = keys.text("exchange", "\"robots\"");
    let (codec, tls) = (keys.word("codec"), keys.word("tls"));
    let example = "{ first_ms = 100, max_ms = 5000, jitter = 0.2 }";
    let reconnect = keys.table("reconnect", "`reconnect`", example, reconnect);
    Some(Broker {
        name,
        url: address?,
        exchange,
        codec,
        tls,
        reconnect,
    })
}

fn reconnect(mut keys: Keys<'_, '_, '_>) -> Reconnect {
    Reconnect {
        first_ms: keys.whole("first_ms", 1..=DAY_MS),
        max_ms: keys.whole("max_ms", 1..=DAY_MS),
        jitter: keys.real("jitter", 0.0..=1.0),
    }
}

pub(crate) fn gateway(reader: &mut Reader<'_>, key: &At<String>, node: &Node) -> Option<Gateway> {
    let name = name::thing(reader, key)?;
    let listen = "\"127.0.0.1:8080\"";
    let mut keys = reader.keys_of(node, key, "a gateway", &format!("{{ listen = {listen} }}"))?;
    keys.need("listen", listen);
    let listen = keys.template("listen", listen);
    let max_connections = keys.whole("max_connections", 1..=10_000);
    let max_body_kb = keys.whole("max_body_kb", 1..=1_000_000);
    Some(Gateway {
        name,
        listen: listen?,
        max_connections,
        max_body_kb,
    })
}

pub(crate) fn bridge(reader: &mut Reader<'_>, key: &At<String>, node: &Node) -> Option<Bridge> {
    let name = name::thing(reader, key)?;
    let mut keys = reader.keys_of(node, key, "a bridge", "{ kind = \"ros2\", domain = 0 }")?;
    keys.need("kind", "\"ros2\"");
    let kind = keys.word("kind");
    let master = keys.template("master", "\"http://127.0.0.1:11311\"");
    let domain = keys.whole("domain", 0..=232);
    let url = keys.template("url", "\"ws://127.0.0.1:9090\"");
    let node = keys.text("node", "\"/composite_bridge\"");
    Some(Bridge {
        name,
        kind: kind?,
        master,
        domain,
        url,
        node,
    })
}
