//! Serialises a plan as a flat composite file with defaults filled in and secrets omitted. The result is a valid
//! composite, and expanding it again yields the same text.

mod binding;
mod component;
mod path;

use toml_edit::{DocumentMut, Item, Table};

pub use self::path::beside;
use crate::joint::{Connection, Promoted, Topic};
use crate::opened::Opened;
use crate::plan::{Bridge, Plan, Terminal, Wire};
use asmotion_composite::model::{ConnectionType, Transport};
use asmotion_composite::table::{Lines, WrittenTable, one_or_many, table, tables};

/// Serialises a plan of `opened`. Relative paths in the result refer to the directory of the outermost composite.
pub fn expand(opened: &Opened, plan: &Plan) -> String {
    let root = &opened.path;
    let types = opened.type_files.iter();
    let types: Vec<String> = types.map(|path| beside(root, path)).collect();
    let mut document = DocumentMut::new();
    let mut head = Lines::new();
    head.put("name", &plan.name);
    head.put("version", &plan.version);
    head.put("types", &types);
    let mut keys = Lines::new();
    keys.put("schema", &"composite/1".to_owned());
    document.extend(keys.items());
    document.insert("composite", Item::Table(table(head)));
    let component = |it| component::component(it, plan, root);
    let sections = [
        (
            "brokers",
            named(&plan.brokers, |it| (&it.name, written(it))),
        ),
        (
            "gateways",
            named(&plan.gateways, |it| (&it.name, written(it))),
        ),
        (
            "bridges",
            named(&plan.bridges, |it| (&it.name, bridge(it, root))),
        ),
        (
            "components",
            named(&plan.components, |it| (&it.name, component(it))),
        ),
        ("topics", topics(&plan.topics)),
    ];
    for (name, section) in sections {
        if !section.is_empty() {
            document.insert(name, Item::Table(section));
        }
    }
    let lists = [
        ("wires", tables(plan.wires.iter().map(|it| wire(it, root)))),
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

fn written(it: &impl WrittenTable) -> Table {
    table(it.keys(""))
}

/// Builds a table of named entries.
fn named<'p, T>(things: &'p [T], show: impl Fn(&'p T) -> (&'p String, Table)) -> Table {
    let mut section = Table::new();
    section.set_implicit(true);
    for thing in things {
        let (name, table) = show(thing);
        section.insert(name, Item::Table(table));
    }
    section
}

/// Topics with settings of their own.
fn topics(topics: &[Topic]) -> Table {
    let mut section = Table::new();
    section.set_implicit(true);
    for topic in topics {
        let keys = topic.sending.keys("");
        if !keys.is_empty() {
            section.insert(&topic.name, Item::Table(table(keys)));
        }
    }
    section
}

/// Serialises a bridge.
fn bridge(bridge: &Bridge, root: &str) -> Table {
    let mut bridge = bridge.clone();
    for folder in &mut bridge.definitions {
        *folder = beside(root, folder);
    }
    written(&bridge)
}

/// Serialises a wire. A local binding is omitted: the transport then follows from the processes of both ends.
fn wire(wire: &Wire, root: &str) -> Lines {
    let mut wire = wire.clone();
    wire.ca = wire.ca.map(|file| beside(root, &file));
    match wire.binding {
        Transport::Local => wire.keys("").without("binding"),
        Transport::Amqp | Transport::Ros | Transport::Http => wire.keys(""),
    }
}

/// Groups connections that share a queue.
fn joint(connections: &[Connection]) -> impl Iterator<Item = &[Connection]> {
    let queue = |connection: &'_ Connection| connection.queue.clone();
    connections.chunk_by(move |one, next| queue(one).is_some() && queue(one) == queue(next))
}

/// Serialises connections with a common policy, every writer of which is connected to every reader.
fn connection(connections: &[Connection]) -> Lines {
    let mut keys = Lines::new();
    let (from, to) = (
        |it: &Connection| it.from.clone(),
        |it: &Connection| it.to.clone(),
    );
    keys.put_some(
        "from",
        one_or_many(&each_once(connections.iter().map(from))),
    );
    keys.put_some("to", one_or_many(&each_once(connections.iter().map(to))));
    if let Some(Connection { policy, .. }) = connections.first() {
        let mut how = policy.keys("");
        // keys without effect would be reported: `size` of a last value, `on_stale` without a maximum age
        if policy.kind == ConnectionType::Data {
            how = how.without("size");
        }
        if policy.max_age_ms.is_none() {
            how = how.without("on_stale");
        }
        keys.put_table("policy", how);
    }
    keys
}

fn each_once(ends: impl Iterator<Item = Terminal>) -> Vec<Terminal> {
    let mut listed = Vec::new();
    for end in ends {
        if !listed.contains(&end) {
            listed.push(end);
        }
    }
    listed
}

fn promoted(promoted: &Promoted) -> Lines {
    let mut keys = Lines::new();
    keys.put(promoted.what, &promoted.inside);
    keys.put("as", &promoted.name);
    keys.put_some("binding", one_or_many(&promoted.bindings));
    keys.put("broker", &promoted.broker);
    keys.put("gateway", &promoted.gateway);
    keys.put("timeout_ms", &promoted.timeout_ms);
    keys
}

fn deploy(plan: &Plan) -> Lines {
    let mut keys = Lines::new();
    keys.put("processes", &plan.processes);
    keys.put("restart", &plan.restart);
    keys.put("record", &plan.record);
    keys
}
