//! A plan as a composite file: opened up, everything filled in, secrets left out. It can be checked and
//! started like any other, and expands to itself.

mod binding;
mod component;
mod path;

use toml_edit::{DocumentMut, Item, Table};

pub use self::path::beside;
use crate::joint::{Connection, Promoted, Topic};
use crate::opened::Opened;
use crate::plan::{Plan, Terminal, Wire};
use asmotion_composite::model::{ConnectionType, Transport};
use asmotion_composite::table::{Lines, WrittenTable, one_or_many, table, tables};

/// The text of a plan of `opened` as a composite file, which belongs beside the outermost one.
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
            named(&plan.bridges, |it| (&it.name, written(it))),
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

fn written(it: &impl WrittenTable) -> Table {
    table(it.keys(""))
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

/// The topics of which more is said than who is on them.
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

/// What a wire goes over is left out where it follows from where its ends are.
fn wire(wire: &Wire) -> Lines {
    match wire.binding {
        Transport::Local => wire.keys("").without("binding"),
        Transport::Amqp | Transport::Ros | Transport::Http => wire.keys(""),
    }
}

/// The connections, those together that share one queue.
fn joint(connections: &[Connection]) -> impl Iterator<Item = &[Connection]> {
    let queue = |connection: &'_ Connection| connection.queue.clone();
    connections.chunk_by(move |one, next| queue(one).is_some() && queue(one) == queue(next))
}

/// Connections of one policy; each of their writers is joined to each of their readers.
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
        // the last value has no size, and nothing grows stale that has no age
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
