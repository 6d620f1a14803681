//! The first difference between two versions of a component that requires a restart, in words.

use asmotion_plan::{Component, Pace, Port, Service};

/// Describes the first difference of two versions of a component that requires a restart, which are given without what can be
/// changed at run time.
pub(super) fn described(before: &Component, after: &Component) -> String {
    key(before, after).unwrap_or_else(|| "keys of its implementation".to_owned())
}

/// Describes what of such a component can be changed at run time.
pub(super) fn changeable(component: &Component) -> &'static str {
    if component.binding.is_some() {
        "its properties, its period, its topics, its specification and its bindings"
    } else {
        "its properties, its period and its topics"
    }
}

/// Returns the first key that differs.
fn key(before: &Component, after: &Component) -> Option<String> {
    let same = [
        (
            "`implementation`",
            before.implementation == after.implementation,
        ),
        ("`task.id`", before.id == after.id),
        ("`lifecycle`", before.lifecycle == after.lifecycle),
    ];
    let differs = same.into_iter().find(|(_, same)| !same);
    differs
        .map(|(key, _)| key.to_owned())
        .or_else(|| schedule(&before.pace, &after.pace).map(str::to_owned))
        .or_else(|| ports("input", &before.inputs, &after.inputs))
        .or_else(|| ports("output", &before.outputs, &after.outputs))
        .or_else(|| services("service", &before.services, &after.services))
        .or_else(|| services("reference", &before.references, &after.references))
        .or_else(|| {
            let is_other = before.bridge != after.bridge || before.program != after.program;
            is_other.then(|| "its declaration".to_owned())
        })
}

/// Returns the first key of `task` or `activity` that differs.
fn schedule(before: &Pace, after: &Pace) -> Option<&'static str> {
    let same = [
        ("`delay_ms`", before.delay_ms == after.delay_ms),
        (
            "`run_on_startup`",
            before.run_on_startup == after.run_on_startup,
        ),
        ("`overrun`", before.overrun == after.overrun),
        (
            "`may_interrupt_if_running`",
            before.may_interrupt_if_running == after.may_interrupt_if_running,
        ),
        ("`broker`", before.broker == after.broker),
        ("`scheduler`", before.scheduler == after.scheduler),
        ("`priority`", before.priority == after.priority),
        ("`cpu`", before.cpu == after.cpu),
        ("`deadline_ms`", before.deadline_ms == after.deadline_ms),
        ("`on_deadline`", before.on_deadline == after.on_deadline),
        ("`master`", before.master == after.master),
    ];
    let differs = same.into_iter().find(|(_, same)| !same);
    let other = (before != after).then_some("other keys of `task` or `activity` than the period");
    differs.map(|(key, _)| key).or(other)
}

/// Returns the first port that differs.
fn ports(what: &str, before: &[Port], after: &[Port]) -> Option<String> {
    for port in before {
        let name = &port.name;
        let Some(other) = after.iter().find(|it| it.name == *name) else {
            return Some(format!("its {what} `{name}`, which is removed"));
        };
        if port.kind != other.kind {
            return Some(format!("the type of its {what} `{name}`"));
        }
    }
    let mut new = after.iter().map(|it| &it.name);
    let new = new.find(|name| before.iter().all(|it| it.name != **name));
    new.map(|name| format!("its {what} `{name}`, which is new"))
        .or_else(|| (before != after).then(|| format!("the order of its {what}s")))
}

/// Returns the first service or reference that differs.
fn services(what: &str, before: &[Service], after: &[Service]) -> Option<String> {
    for service in before {
        let name = &service.name;
        match after.iter().find(|it| it.name == *name) {
            None => return Some(format!("its {what} `{name}`, which is removed")),
            Some(other) if other != service => {
                return Some(format!("the interface of its {what} `{name}`"));
            }
            Some(_) => {}
        }
    }
    let mut new = after.iter().map(|it| &it.name);
    let new = new.find(|name| before.iter().all(|it| it.name != **name));
    new.map(|name| format!("its {what} `{name}`, which is new"))
        .or_else(|| (before != after).then(|| format!("the order of its {what}s")))
}
