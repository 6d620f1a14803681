//! One component.

use toml_edit::{Item, Table};

use super::binding;
use super::write::{Keys, beside, table, value};
use crate::model::{Builtin, OnDeadline};
use crate::plan::{
    Component, Implementation, Notify, Pace, Plan, Port, ProxyEntry, RosEntry, Service, Terminal,
};

pub(super) fn component(component: &Component, plan: &Plan, root: &str) -> Table {
    let mut keys = Keys::new();
    keys.inline(
        "implementation",
        implementation(&component.implementation, root),
    );
    pace(component, &mut keys);
    let lifecycle = &component.lifecycle;
    let mut life = Keys::new();
    life.flag("autoconf", lifecycle.autoconf);
    life.flag("autostart", lifecycle.autostart);
    life.word("on_exception", lifecycle.on_exception);
    life.whole("max_resets", lifecycle.max_resets);
    keys.inline("lifecycle", life);
    ports(component, plan, &mut keys);
    keys.inline("services", services(&component.services));
    keys.inline("references", references(component, plan));
    let mut settings = Keys::new();
    for (name, set) in &component.properties.0 {
        settings.put(name, value(set));
    }
    keys.inline("properties", settings);
    if let Some(verify) = &component.verify {
        let mut verified = Keys::new();
        verified.flag("ctl", verify.ctl);
        verified.flag("ltl", verify.ltl);
        verified.flag("invariants", verify.invariants);
        verified.flag("refuse_start_on_failure", verify.refuse_start_on_failure);
        keys.inline("verify", verified);
    }
    builtin(component, &mut keys);
    let mut table = table(keys);
    let bind = component.binding.as_ref().map(binding::bind);
    if let Some(bind) = bind.filter(|bind| !bind.is_empty()) {
        table.insert("bind", Item::Table(bind));
    }
    table
}

fn implementation(made_of: &Implementation, root: &str) -> Keys {
    let mut keys = Keys::new();
    let mut words = |first: &str, rest: &str, words: &[String]| {
        keys.texts(first, words.first());
        match rest {
            "arguments" => keys.list(rest, words.iter().skip(1).cloned()),
            _ => keys.texts(rest, words.get(1)),
        }
    };
    match made_of {
        Implementation::Process(all) => words("process", "arguments", all),
        Implementation::Ros(all) => words("ros", "executable", all),
        Implementation::Orocos(all) => words("orocos", "name_service", all),
        Implementation::Rust(name) => keys.text("rust", name),
        Implementation::Asm(asm) => {
            keys.text("asm", &beside(root, &asm.path));
            keys.texts("main", asm.main.iter());
        }
        Implementation::Builtin(builtin) => {
            keys.word("builtin", builtin.kind);
            keys.texts("target", builtin.target.iter());
            keys.texts("bridge", builtin.bridge.iter());
            keys.wholes("port", builtin.port);
        }
    }
    keys
}

/// A `task`, unless something is said that only an `activity` can say.
fn pace(component: &Component, keys: &mut Keys) {
    let Pace {
        period_ms,
        delay_ms,
        run_on_startup,
        may_interrupt_if_running,
        overrun,
        broker,
        scheduler,
        priority,
        cpu,
        deadline_ms,
        on_deadline,
        master,
    } = &component.pace;
    let scheduled = scheduler.is_some()
        || priority.is_some()
        || !cpu.is_empty()
        || deadline_ms.is_some()
        || *on_deadline != OnDeadline::default()
        || master.is_some();
    let mut pace = Keys::new();
    if !scheduled {
        pace.text("id", &component.id);
    }
    pace.whole("period_ms", *period_ms);
    pace.whole("delay_ms", *delay_ms);
    pace.flag("run_on_startup", *run_on_startup);
    pace.word("overrun", *overrun);
    if !scheduled {
        pace.flag("may_interrupt_if_running", *may_interrupt_if_running);
        pace.texts("broker", broker.iter());
        return keys.inline("task", pace);
    }
    if let Some(scheduler) = scheduler {
        pace.word("scheduler", *scheduler);
    }
    pace.wholes("priority", *priority);
    pace.numbers("cpu", cpu);
    pace.wholes("deadline_ms", *deadline_ms);
    pace.word("on_deadline", *on_deadline);
    pace.texts("master", master.iter());
    keys.inline("activity", pace);
}

/// Ports that are on a topic or joined, and those that nobody else would know of.
fn ports(component: &Component, plan: &Plan, keys: &mut Keys) {
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
        let mut listed = Keys::new();
        let ports = ports.iter().filter(|port| port.topic.is_some() == on_topic);
        for port in ports.filter(|port| on_topic || !declares || joined(port)) {
            listed.text(&port.name, &port.kind);
        }
        listed
    };
    let mut ports = Keys::new();
    ports.inline("in", listed(&component.inputs, false));
    ports.inline("out", listed(&component.outputs, false));
    keys.inline("ports", ports);
    keys.inline("subscribe", listed(&component.inputs, true));
    keys.inline("publish", listed(&component.outputs, true));
    let mut rename = Keys::new();
    for port in component.inputs.iter().chain(&component.outputs) {
        if let Some(topic) = port.topic.as_ref().filter(|topic| **topic != port.name) {
            rename.text(&port.name, topic);
        }
    }
    keys.inline("rename", rename);
}

fn services(services: &[Service]) -> Keys {
    let mut keys = Keys::new();
    for service in services {
        keys.text(&service.name, &service.interface);
    }
    keys
}

/// References; one that leads nowhere was allowed to.
fn references(component: &Component, plan: &Plan) -> Keys {
    let mut keys = Keys::new();
    for reference in &component.references {
        let end = format!("{}.{}", component.name, reference.name);
        let mut wires = plan.wires.iter();
        let mut promoted = plan.promoted.iter();
        let leads = wires.any(|wire| wire.reference.to_string() == end)
            || promoted.any(|it| it.what == "reference" && it.inside == end);
        if leads {
            keys.text(&reference.name, &reference.interface);
        } else {
            let mut optional = Keys::new();
            optional.text("interface", &reference.interface);
            optional.flag("optional", true);
            keys.inline(&reference.name, optional);
        }
    }
    keys
}

/// What only built-ins have.
fn builtin(component: &Component, keys: &mut Keys) {
    let kind = match &component.implementation {
        Implementation::Builtin(builtin) => Some(builtin.kind),
        _ => None,
    };
    let target = match &component.implementation {
        Implementation::Builtin(builtin) => builtin.target.as_deref().unwrap_or_default(),
        _ => "",
    };
    match kind {
        Some(Builtin::RosBridge) => keys.tables("map", component.ros.iter().map(ros)),
        _ => keys.tables("map", component.proxy.iter().map(|it| proxy(it, target))),
    }
    if let Some(notify) = &component.notify {
        keys.inline("notify", notified(notify));
    }
    let plots = component.plots.iter().map(|plot| {
        let mut keys = Keys::new();
        keys.text("title", &plot.title);
        keys.texts("each", plot.each.iter());
        keys.list("series", plot.series.iter().cloned());
        keys.texts("flags", plot.flags.iter());
        keys.whole("window_s", plot.window_s);
        keys
    });
    keys.tables("plots", plots);
}

fn proxy(entry: &ProxyEntry, target: &str) -> Keys {
    let mut keys = Keys::new();
    keys.text(
        "operation",
        &format!("{}.{}", entry.service, entry.operation),
    );
    keys.text("port", &format!("{target}.{}", entry.port));
    keys.word("mode", entry.mode);
    keys.texts("field", entry.field.iter());
    keys
}

fn ros(entry: &RosEntry) -> Keys {
    let mut keys = Keys::new();
    keys.text("from", &entry.port);
    keys.text("ros", &entry.ros);
    keys.text("type", &entry.kind);
    keys.word("direction", entry.direction);
    keys.texts("convert", entry.convert.iter());
    keys
}

fn notified(notify: &Notify) -> Keys {
    let mut keys = Keys::new();
    keys.text("reference", &notify.reference);
    keys.texts("busy", notify.busy.iter());
    if let Some(idle) = &notify.idle {
        let mut near = Keys::new();
        near.real("within", idle.within);
        near.text("of", &idle.of);
        near.text("on", &idle.on);
        near.whole("for_ms", idle.for_ms);
        keys.inline("idle", near);
    }
    keys.texts("refresh", notify.refresh.iter());
    keys.texts("fault", notify.fault.iter());
    keys.wholes("stale_ms", notify.stale_ms);
    keys
}
