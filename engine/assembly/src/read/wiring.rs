//! `[[wires]]` and `[[connections]]`.

use super::endpoint::DAY_MS;
use super::keys::{Keys, Reader};
use super::name;
use crate::model::{Connection, Policy, Retry, Terminal, Wire};
use crate::tree::Node;

pub(crate) fn wire(reader: &mut Reader<'_>, node: &Node) -> Option<Wire> {
    let example = "{ reference = \"Coordinator.planner\", service = \"Planner.planning\" }";
    let mut keys = reader.keys_of(node, "wires", "a wire", example)?;
    let span = keys.span;
    let reference = keys.needed_text("reference", "\"Coordinator.planner\"");
    keys.need("service", "\"Planner.planning\"");
    let services = keys.texts("service", "\"Planner.planning\"");
    let reference = reference.and_then(|text| name::end(keys.reader, &text));
    let services = services
        .iter()
        .filter_map(|text| name::end(keys.reader, text))
        .collect();
    let (profiles, binding) = (keys.texts("profile", "\"sim\""), keys.word("binding"));
    let broker = keys.text("broker", "\"main\"");
    let timeout_ms = keys.whole("timeout_ms", 1..=DAY_MS);
    let retry = keys.table(
        "retry",
        "`retry`",
        "{ attempts = 2, backoff_ms = 100 }",
        retry,
    );
    let (cancel, oneway) = (keys.word("cancel"), keys.flag("oneway"));
    let reference = reference?;
    Some(Wire {
        span,
        profiles,
        reference,
        services,
        binding,
        broker,
        timeout_ms,
        retry,
        cancel,
        oneway,
    })
}

fn retry(mut keys: Keys<'_, '_, '_>) -> Retry {
    Retry {
        attempts: keys.whole("attempts", 0..=1000),
        backoff_ms: keys.whole("backoff_ms", 0..=DAY_MS),
    }
}

pub(crate) fn connection(reader: &mut Reader<'_>, node: &Node) -> Option<Connection> {
    let example = "{ from = \"Laser.scan\", to = \"Adapter.scan\" }";
    let mut keys = reader.keys_of(node, "connections", "a connection", example)?;
    let span = keys.span;
    let from = terminals(&mut keys, "from", "\"Laser.scan\"");
    let to = terminals(&mut keys, "to", "\"topic:scan\"");
    let profiles = keys.texts("profile", "\"sim\"");
    let policy = keys.table(
        "policy",
        "a connection policy",
        "{ type = \"data\" }",
        policy,
    );
    let policy = policy.unwrap_or_else(|| Policy {
        span,
        ..Policy::default()
    });
    Some(Connection {
        span,
        profiles,
        from,
        to,
        policy,
    })
}

fn terminals(keys: &mut Keys<'_, '_, '_>, key: &'static str, example: &str) -> Vec<Terminal> {
    keys.need(key, example);
    let texts = keys.texts(key, example);
    texts
        .iter()
        .filter_map(|text| name::terminal(keys.reader, text))
        .collect()
}

fn policy(mut keys: Keys<'_, '_, '_>) -> Policy {
    Policy {
        span: keys.span,
        kind: keys.word("type"),
        size: keys.whole("size", 1..=1_000_000),
        lock: keys.word("lock"),
        init: keys.flag("init"),
        pull: keys.flag("pull"),
        mandatory: keys.flag("mandatory"),
        buffer: keys.word("buffer"),
        max_threads: keys.whole("max_threads", 1..=1024),
        data_size: keys.whole("data_size", 1..=16_777_216),
        max_age_ms: keys.whole("max_age_ms", 1..=DAY_MS),
        on_stale: keys.word("on_stale"),
        delivery: keys.word("delivery"),
        poll_ms: keys.whole("poll_ms", 1..=DAY_MS),
    }
}
