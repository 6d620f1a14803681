//! States and steps as text and as JSON.

use asmotion_lang::Step;
use asmotion_lang::machine::Machine;
use asmotion_lang::simulate;
use serde_json::{Map, Value, json};

/// Returns every location with a value, as pairs of location and value.
pub fn state(machine: &Machine) -> Vec<(String, String)> {
    let naming = machine.naming();
    let mut locations: Vec<(String, String)> = machine
        .state()
        .locations(machine.program())
        .into_iter()
        .filter(|(_, _, slot)| !machine.state().get(*slot).is_undef())
        .map(|(function, arguments, slot)| {
            let location = simulate::applied(machine, function, &arguments);
            (
                location,
                machine.state().get(slot).show(&naming).to_string(),
            )
        })
        .collect();
    locations.sort();
    locations
}

/// A step as JSON.
pub fn step_json(machine: &Machine, step: &Step<'_>) -> Value {
    let naming = machine.naming();
    let inputs: Map<String, Value> = step
        .inputs()
        .iter()
        .map(|input| {
            let value = input.value.show(&naming).to_string();
            (
                simulate::location(machine, input.slot),
                Value::String(value),
            )
        })
        .collect();
    let updates: Vec<Value> = simulate::updates(machine, step)
        .into_iter()
        .map(|(location, before, after)| json!({ "location": location, "before": before, "after": after }))
        .collect();
    let choices: Vec<Value> = step
        .choices()
        .iter()
        .map(|choice| json!({ "index": choice.index, "of": choice.count }))
        .collect();
    let sent: Vec<String> = step
        .sent()
        .iter()
        .map(|sent| simulate::sent(machine, sent))
        .collect();
    json!({
        "type": "step", "v": 1, "step": step.number(),
        "inputs": inputs, "choices": choices, "updates": updates, "printed": step.printed(),
        "sent": sent,
    })
}
