//! Text form of locations, updates and messages.

use asmotion_ir::Slot;
use asmotion_machine::{Machine, SentKind, SentMessage, Step};
use asmotion_value::Value;

/// Formats a location, as in `doing(ROB1, TASK2)`.
pub fn location(machine: &Machine, slot: Slot) -> String {
    let Some((function, arguments)) = machine.state().location(machine.program(), slot) else {
        return format!("location {slot}");
    };
    applied(machine, function, &arguments)
}

/// Formats a function applied to arguments.
pub fn applied(
    machine: &Machine,
    function: asmotion_ir::FunctionId,
    arguments: &[Value],
) -> String {
    let name = &machine.program().symbols.functions[function.0 as usize];
    if arguments.is_empty() {
        return name.to_string();
    }
    let naming = machine.naming();
    let arguments: Vec<String> = arguments
        .iter()
        .map(|value| value.show(&naming).to_string())
        .collect();
    format!("{name}({})", arguments.join(", "))
}

/// Returns every location with a value, as pairs of location and value, sorted by location.
pub fn state(machine: &Machine) -> Vec<(String, String)> {
    let naming = machine.naming();
    let mut locations: Vec<(String, String)> = machine
        .state()
        .locations(machine.program())
        .into_iter()
        .filter(|(_, _, slot)| !machine.state().get(*slot).is_undef())
        .map(|(function, arguments, slot)| {
            let location = applied(machine, function, &arguments);
            let value = machine.state().get(slot).show(&naming).to_string();
            (location, value)
        })
        .collect();
    locations.sort();
    locations
}

/// Returns the updates of the last step as location, previous value and new value, sorted by
/// location.
pub fn updates(machine: &Machine, step: &Step<'_>) -> Vec<(String, String, String)> {
    let naming = machine.naming();
    let mut shown: Vec<(String, String, String)> = step
        .updates()
        .iter()
        .zip(step.before())
        .map(|(update, before)| {
            let show = |value: &Value| value.show(&naming).to_string();
            (
                location(machine, update.slot),
                show(before),
                show(&update.value),
            )
        })
        .collect();
    shown.sort();
    shown
}

/// Formats a message sent by a step, as in `self -> planner: plan((3,4))`.
pub fn sent(machine: &Machine, sent: &SentMessage) -> String {
    let naming = machine.naming();
    let (from, to) = (sent.from.show(&naming), sent.to.show(&naming));
    let operation = if let Value::Text(text) = &sent.operation {
        text.as_str()
    } else {
        ""
    };
    let operation = asmotion_stdlib::operation(operation);
    match &sent.kind {
        SentKind::Message { data } => {
            format!("{from} -> {to}: {operation}({})", data.show(&naming))
        }
        SentKind::Call { data, deadline_ns } => {
            let data = data.show(&naming);
            match deadline_ns {
                Some(deadline) => {
                    format!("{from} -> {to}: call {operation}({data}) until {deadline} ns")
                }
                None => format!("{from} -> {to}: call {operation}({data})"),
            }
        }
        SentKind::Reply { data, .. } => {
            format!(
                "{from} -> {to}: reply to {operation}: {}",
                data.show(&naming)
            )
        }
        SentKind::Cancel { .. } => format!("{from} -> {to}: cancel {operation}"),
    }
}
