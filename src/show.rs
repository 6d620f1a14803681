//! Steps as JSON, and guards in words.

use asmotion_lang::Step;
use asmotion_lang::guards::PassedGuard;
use asmotion_lang::machine::Machine;
use asmotion_lang::simulate;
use serde_json::{Map, Value, json};

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

/// A guard with the values that it read.
pub fn guard(guard: &PassedGuard) -> String {
    let PassedGuard {
        text,
        holds,
        values,
        ..
    } = guard;
    let text = if *holds {
        format!("`{text}`")
    } else {
        format!("not `{text}`")
    };
    let values = values
        .iter()
        .map(|(name, value)| format!("{name} = {value}"));
    let values: Vec<_> = values.collect();
    if values.is_empty() {
        text
    } else {
        format!("{text}, with {}", values.join(", "))
    }
}
