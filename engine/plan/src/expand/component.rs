//! Serialises a component.

use toml_edit::{Item, Table};

use super::beside;
use super::binding;
use crate::component::{Component, Implementation, Port, Service};
use crate::plan::{Pace, Plan, Terminal};
use asmotion_composite::model::BuiltinComponent;
use asmotion_composite::table::{Lines, WrittenTable, table};

pub(super) fn component(component: &Component, plan: &Plan, root: &str) -> Table {
    let mut keys = Lines::new();
    let made_of = implementation(&component.implementation, root);
    keys.put_table("implementation", made_of);
    pace(component, &mut keys);
    keys.put("lifecycle", &component.lifecycle);
    ports(component, plan, &mut keys);
    keys.put_table("services", services(&component.services));
    keys.put_table("references", references(component, plan));
    keys.put("properties", &component.properties);
    keys.put("verify", &component.verify);
    builtin(component, &mut keys);
    let mut table = table(keys);
    let bind = component.binding.as_ref().map(binding::bind);
    if let Some(bind) = bind.filter(|bind| !bind.is_empty()) {
        table.insert("bind", Item::Table(bind));
    }
    table
}

fn implementation(made_of: &Implementation, root: &str) -> Lines {
    let mut keys = Lines::new();
    let mut words = |first: &str, rest: &str, words: &[String]| {
        keys.put(first, &words.first().cloned());
        match rest {
            "arguments" => keys.put(rest, &words.get(1..).unwrap_or_default().to_vec()),
            _ => keys.put(rest, &words.get(1).cloned()),
        }
    };
    match made_of {
        Implementation::Process(all) => words("process", "arguments", all),
        Implementation::Ros(all) => words("ros", "executable", all),
        Implementation::Orocos(all) => words("orocos", "name_service", all),
        Implementation::Rust(name) => keys.put("rust", name),
        Implementation::Asm(asm) => {
            keys.put("asm", &beside(root, &asm.path));
            keys.put("main", &asm.main);
        }
        Implementation::Builtin(builtin) => {
            keys.put("builtin", &builtin.kind);
            keys.put("target", &builtin.target);
            keys.put("bridge", &builtin.bridge);
            keys.put("port", &builtin.port);
        }
    }
    keys
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
        Implementation::Rust(_) | Implementation::Builtin(_)
    );
    let joined = |port: &Port| {
        let end = format!("{}.{}", component.name, port.name);
        let is_end = |terminal: &Terminal| terminal.to_string() == end;
        let mut connections = plan.connections.iter();
        let mut promoted = plan.promoted.iter();
        connections.any(|it| is_end(&it.from) || is_end(&it.to))
            || promoted.any(|it| it.what == "port" && it.inside == end)
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
        let end = format!("{}.{}", component.name, reference.name);
        let mut wires = plan.wires.iter();
        let mut promoted = plan.promoted.iter();
        let leads = wires.any(|wire| wire.reference.to_string() == end)
            || promoted.any(|it| it.what == "reference" && it.inside == end);
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

/// Serialises keys specific to built-in components.
fn builtin(component: &Component, keys: &mut Lines) {
    let builtin = if let Implementation::Builtin(builtin) = &component.implementation {
        Some(builtin)
    } else {
        None
    };
    let kind = builtin.map(|builtin| builtin.kind);
    let target = builtin
        .and_then(|builtin| builtin.target.as_deref())
        .unwrap_or_default();
    // ports of a proxy mirror those of its target
    let proxy: Vec<_> = component
        .proxy
        .iter()
        .map(|entry| {
            let mut entry = entry.clone();
            target.clone_into(&mut entry.port.component);
            entry
        })
        .collect();
    match kind {
        Some(BuiltinComponent::RosBridge) => keys.put("map", &component.ros),
        _ => keys.put("map", &proxy),
    }
    keys.put("notify", &component.notify);
    keys.put("plots", &component.plots);
}
