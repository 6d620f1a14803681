//! A plan as a composite file: opened up, everything filled in, secrets left out. It can be checked and
//! started like any other, and expands to itself.

mod binding;
mod component;
mod write;

use toml_edit::{Array, DocumentMut, Item, Table};

pub use self::write::beside;
pub(crate) use self::write::value as toml;
use self::write::{Keys, table, tables};
use crate::model::{BridgeKind, Flow, Transport};
use crate::opened::Opened;
use crate::plan::{
    Bridge, Broker, Connection, Gateway, Plan, Policy, Promoted, Terminal, Topic, Wire,
};

/// The text of a plan of `opened` as a composite file, which belongs beside the outermost one.
pub fn expand(opened: &Opened, plan: &Plan) -> String {
    let root = &opened.path;
    let types = opened
        .type_files
        .iter()
        .map(|path| write::beside(root, path));
    let mut document = DocumentMut::new();
    let mut head = Keys::new();
    head.text("name", &plan.name);
    head.texts("version", plan.version.iter());
    head.list("types", types);
    let mut keys = Keys::new();
    keys.text("schema", "composite/1");
    document.extend(keys.items());
    document.insert("composite", Item::Table(table(head)));
    let sections = [
        ("brokers", named(&plan.brokers, |it| (&it.name, broker(it)))),
        (
            "gateways",
            named(&plan.gateways, |it| (&it.name, gateway(it))),
        ),
        ("bridges", named(&plan.bridges, |it| (&it.name, bridge(it)))),
        (
            "components",
            named(&plan.components, |it| {
                (&it.name, component::component(it, plan, root))
            }),
        ),
        ("topics", topics(&plan.topics)),
    ];
    for (name, section) in sections {
        if !section.is_empty() {
            document.insert(name, Item::Table(section));
        }
    }
    let lists = [
        ("wires", tables(plan.wires.iter().map(wire))),
        (
            "connections",
            tables(joint(&plan.connections).map(connection)),
        ),
        ("promote", tables(plan.promoted.iter().map(promoted))),
    ];
    for (name, list) in lists {
        if !list.is_empty() {
            document.insert(name, Item::ArrayOfTables(list));
        }
    }
    document.insert("deploy", Item::Table(table(deploy(plan))));
    document.to_string()
}

/// A table of things by name.
fn named<'p, T>(things: &'p [T], show: impl Fn(&'p T) -> (&'p String, Table)) -> Table {
    let mut section = Table::new();
    section.set_implicit(true);
    for thing in things {
        let (name, table) = show(thing);
        section.insert(name, Item::Table(table));
    }
    section
}

fn broker(broker: &Broker) -> Table {
    let mut keys = Keys::new();
    keys.texts("url", broker.url.iter().map(|url| url.shown()));
    keys.text("exchange", &broker.exchange);
    keys.word("codec", broker.codec);
    keys.word("tls", broker.tls);
    let mut reconnect = Keys::new();
    reconnect.whole("first_ms", broker.reconnect_first_ms);
    reconnect.whole("max_ms", broker.reconnect_max_ms);
    reconnect.real("jitter", broker.reconnect_jitter);
    keys.inline("reconnect", reconnect);
    table(keys)
}

fn gateway(gateway: &Gateway) -> Table {
    let mut keys = Keys::new();
    keys.words("listen", gateway.listen);
    keys.whole("max_connections", gateway.max_connections);
    keys.whole("max_body_kb", gateway.max_body_kb);
    table(keys)
}

fn bridge(bridge: &Bridge) -> Table {
    let mut keys = Keys::new();
    keys.word("kind", bridge.kind);
    let address = match bridge.kind {
        BridgeKind::Ros1 => "master",
        BridgeKind::Ros2 | BridgeKind::Rosbridge => "url",
    };
    keys.texts(address, bridge.url.iter().map(|url| url.shown()));
    keys.wholes("domain", bridge.domain);
    keys.texts("node", bridge.node.iter());
    table(keys)
}

/// The topics of which more is said than who is on them.
fn topics(topics: &[Topic]) -> Table {
    let mut section = Table::new();
    section.set_implicit(true);
    for topic in topics {
        let mut keys = Keys::new();
        keys.flags("confirm", topic.confirm);
        keys.words("outage", topic.outage);
        keys.wholes("size", topic.size);
        keys.words("codec", topic.codec);
        if !keys.is_empty() {
            section.insert(&topic.name, Item::Table(table(keys)));
        }
    }
    section
}

fn wire(wire: &Wire) -> Keys {
    let mut keys = Keys::new();
    keys.text("reference", &wire.reference.to_string());
    keys.one_or_many("service", wire.services.iter().map(ToString::to_string));
    keys.words("binding", remote(wire.binding));
    keys.texts("broker", wire.broker.iter());
    keys.whole("timeout_ms", wire.timeout_ms);
    let mut retry = Keys::new();
    retry.whole("attempts", wire.retry_attempts);
    retry.whole("backoff_ms", wire.retry_backoff_ms);
    keys.inline("retry", retry);
    keys.word("cancel", wire.cancel);
    keys.flag("oneway", wire.oneway);
    keys
}

/// What something goes over, unless that follows from where its ends are.
fn remote(binding: Transport) -> Option<Transport> {
    Some(binding).filter(|binding| *binding != Transport::Local)
}

/// The connections, those together that share one queue.
fn joint(connections: &[Connection]) -> impl Iterator<Item = &[Connection]> {
    let queue = |connection: &'_ Connection| connection.policy.queue.clone();
    connections.chunk_by(move |one, next| queue(one).is_some() && queue(one) == queue(next))
}

/// Connections of one policy; each of their writers is joined to each of their readers.
fn connection(connections: &[Connection]) -> Keys {
    let mut keys = Keys::new();
    keys.one_or_many("from", each_once(connections.iter().map(|it| &it.from)));
    keys.one_or_many("to", each_once(connections.iter().map(|it| &it.to)));
    if let Some(connection) = connections.first() {
        keys.inline("policy", policy(&connection.policy));
    }
    keys
}

fn each_once<'p>(ends: impl Iterator<Item = &'p Terminal>) -> impl Iterator<Item = String> {
    let mut listed: Vec<String> = Vec::new();
    for end in ends.map(Terminal::to_string) {
        if !listed.contains(&end) {
            listed.push(end);
        }
    }
    listed.into_iter()
}

fn policy(policy: &Policy) -> Keys {
    let mut how = Keys::new();
    how.word("type", policy.kind);
    // the last value has no size
    how.wholes(
        "size",
        Some(policy.size).filter(|_| policy.kind != Flow::Data),
    );
    how.word("lock", policy.lock);
    how.flag("init", policy.init);
    how.flag("pull", policy.pull);
    how.flag("mandatory", policy.mandatory);
    how.word("buffer", policy.buffer);
    how.wholes("max_threads", policy.max_threads);
    how.wholes("max_age_ms", policy.max_age_ms);
    // nothing grows stale that has no age
    how.words("on_stale", policy.max_age_ms.map(|_| policy.on_stale));
    how.word("delivery", policy.delivery);
    how.wholes("poll_ms", policy.poll_ms);
    how.wholes("data_size", policy.data_size);
    how
}

fn promoted(promoted: &Promoted) -> Keys {
    let mut keys = Keys::new();
    keys.text(promoted.what, &promoted.inside);
    keys.text("as", &promoted.name);
    let bindings = promoted.bindings.iter();
    keys.one_or_many("binding", bindings.map(ToString::to_string));
    keys.texts("broker", promoted.broker.iter());
    keys.texts("gateway", promoted.gateway.iter());
    keys.wholes("timeout_ms", promoted.timeout_ms);
    keys
}

fn deploy(plan: &Plan) -> Keys {
    let mut keys = Keys::new();
    let processes = plan.processes.iter().map(|process| {
        let mut keys = Keys::new();
        keys.text("name", &process.name);
        keys.texts("host", process.host.iter());
        keys.put("components", process.components.iter().collect::<Array>());
        keys.word("scheduler", process.scheduler);
        keys.wholes("priority", process.priority);
        keys.numbers("cpu", &process.cpu);
        keys
    });
    keys.tables("processes", processes);
    if let Some(restart) = &plan.restart {
        let mut restarted = Keys::new();
        restarted.word("policy", restart.policy);
        restarted.whole("max", restart.max);
        restarted.whole("window_s", restart.window_s);
        restarted.numbers("backoff_ms", &restart.backoff_ms);
        keys.inline("restart", restarted);
    }
    if let Some(record) = &plan.record {
        let mut recorded = Keys::new();
        recorded.text("dir", &record.dir);
        recorded.list("topics", record.topics.iter().cloned());
        recorded.flag("calls", record.calls);
        recorded.flag("asm_states", record.asm_states);
        recorded.whole("rotate_mb", record.rotate_mb);
        keys.inline("record", recorded);
    }
    keys
}
