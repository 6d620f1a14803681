//! Serialises a component.

use toml_edit::{Item, Table};

use super::beside;
use super::binding;
use crate::component::{Component, Port, Service};
use crate::plan::{End, Implementation, Pace, Plan, Terminal};
use asmotion_composite::table::{Lines, WrittenTable, table};

pub(super) fn component(component: &Component, plan: &Plan, root: &str) -> Table {
    let mut keys = Lines::new();
    keys.put("implementation", &implementation(component, root));
    pace(component, &mut keys);
    keys.put("lifecycle", &component.lifecycle);
    ports(component, plan, &mut keys);
    keys.put_table("services", services(&component.services));
    keys.put_table("references", references(component, plan));
    keys.put("properties", &component.properties);
    let mut special = component.special.clone();
    special.protocol = special.protocol.map(|file| beside(root, &file));
    keys.append(special.keys(""));
    let mut table = table(keys);
    let bind = component.binding.as_deref().map(binding::bind);
    if let Some(bind) = bind.filter(|bind| !bind.is_empty()) {
        table.insert("bind", Item::Table(bind));
    }
    table
}

/// Returns the implementation with the path of its specification relative to the composite.
fn implementation(component: &Component, root: &str) -> Implementation {
    let mut implementation = component.implementation.clone();
    if let Implementation::Asm { file, .. } = &mut implementation {
        *file = beside(root, file);
    }
    if let Implementation::Process { directory, .. } = &mut implementation {
        let written = directory.as_deref().map(|it| beside(root, it));
        *directory = written.filter(|it| !matches!(&**it, "" | "."));
    }
    implementation
}

/// Serialises the schedule as `task`, or as `activity` if it uses keys that only `activity` has.
fn pace(component: &Component, keys: &mut Lines) {
    let pace = &component.pace;
    let task = Pace {
        scheduler: None,
        priority: None,
        cpu: Vec::new(),
        deadline_ms: None,
        on_deadline: Default::default(),
        master: None,
        ..pace.clone()
    };
    if *pace == task {
        let mut lines = Lines::new();
        lines.put("id", &component.id);
        lines.append(pace.keys("task"));
        keys.put_table("task", lines);
    } else {
        let mut lines = pace.keys("activity");
        // no cycle is late that has no deadline
        if pace.deadline_ms.is_none() {
            lines = lines.without("on_deadline");
        }
        keys.put_table("activity", lines);
    }
}

/// Serialises the ports that are connected, and all ports if the implementation does not declare them.
fn ports(component: &Component, plan: &Plan, keys: &mut Lines) {
    let declares = matches!(
        component.implementation,
        Implementation::Rust(_) | Implementation::Builtin { .. }
    ) || component.program.is_some();
    let joined = |port: &Port| {
        let end = End {
            component: component.name.clone(),
            name: port.name.clone(),
        };
        let (inside, end) = (end.to_string(), Terminal::Port(end));
        let mut connections = plan.connections.from_end(&end);
        let mut connections_to = plan.connections.to_end(&end);
        let mut promoted = plan.promoted.iter();
        connections.next().is_some()
            || connections_to.next().is_some()
            || promoted.any(|it| it.what == "port" && it.inside == inside)
    };
    let listed = |ports: &[Port], on_topic: bool| {
        let mut listed = Lines::new();
        let ports = ports.iter().filter(|port| port.topic.is_some() == on_topic);
        for port in ports.filter(|port| on_topic || !declares || joined(port)) {
            listed.put(&port.name, &port.kind);
        }
        listed
    };
    let mut ports = Lines::new();
    ports.put_table("in", listed(&component.inputs, false));
    ports.put_table("out", listed(&component.outputs, false));
    keys.put_table("ports", ports);
    keys.put_table("subscribe", listed(&component.inputs, true));
    keys.put_table("publish", listed(&component.outputs, true));
    let mut rename = Lines::new();
    for port in component.inputs.iter().chain(&component.outputs) {
        if let Some(topic) = port.topic.as_ref().filter(|topic| **topic != port.name) {
            rename.put(&port.name, topic);
        }
    }
    keys.put_table("rename", rename);
}

fn services(services: &[Service]) -> Lines {
    let mut keys = Lines::new();
    for service in services {
        keys.put(&service.name, &service.interface);
    }
    keys
}

/// Serialises references; those without a wire or promotion are optional.
fn references(component: &Component, plan: &Plan) -> Lines {
    let mut keys = Lines::new();
    for reference in &component.references {
        let end = End {
            component: component.name.clone(),
            name: reference.name.clone(),
        };
        let wired = plan.wires.of_reference(&end).next().is_some();
        let end = end.to_string();
        let mut promoted = plan.promoted.iter();
        let leads = wired || promoted.any(|it| it.what == "reference" && it.inside == end);
        if leads {
            keys.put(&reference.name, &reference.interface);
        } else {
            let mut optional = Lines::new();
            optional.put("interface", &reference.interface);
            optional.put("optional", &true);
            keys.put_table(&reference.name, optional);
        }
    }
    keys
}
