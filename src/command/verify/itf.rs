//! A run in the Informal Trace Format (ITF), a JSON format of model checkers.
//!
//! Integers are `{"#bigint": "…"}`, tuples `{"#tup": […]}`, sets `{"#set": […]}`, functions with arguments and maps
//! `{"#map": [[key, value], …]}`. Elements of enumerations are strings, and so is `undef`.

use super::words::{heading, place_text};
use asmotion_lang::Specification;
use asmotion_verify::{
    CheckedProperty, ExportedValue, LocationValue, Run, RunStep, VerifiedMachine,
};
use serde_json::{Map, Value, json};
use std::collections::{BTreeMap, BTreeSet};

/// Returns a run with its states.
pub fn trace(
    property: &CheckedProperty,
    run: &Run,
    path: &str,
    machines: &[VerifiedMachine],
) -> Value {
    let locations = run.states.iter().flatten();
    let variables: BTreeSet<&str> = locations.clone().map(|it| &*it.function).collect();
    let with_arguments: BTreeSet<&str> = locations
        .filter(|it| !it.arguments.is_empty())
        .map(|it| &*it.function)
        .collect();
    let states = run.states.iter().enumerate().map(|(index, locations)| {
        let mut state = Map::new();
        state.insert("#meta".to_owned(), meta(index, run, machines));
        for variable in &variables {
            let here: Vec<&LocationValue> = locations
                .iter()
                .filter(|it| it.function == *variable)
                .collect();
            let value = if with_arguments.contains(variable) {
                let pairs = here
                    .iter()
                    .map(|it| json!([key(&it.arguments), value(&it.value)]));
                json!({ "#map": pairs.collect::<Vec<Value>>() })
            } else {
                here.first().map_or(json!("undef"), |it| value(&it.value))
            };
            state.insert((*variable).to_owned(), value);
        }
        Value::Object(state)
    });
    let states: Vec<Value> = states.collect();
    let mut trace = json!({
        "#meta": {
            "format": "ITF",
            "format-description": "https://apalache-mc.org/docs/adr/015adr-trace.html",
            "description": heading(property),
            "source": path,
            "status": if property.verdict.is_violated() { "violation" } else { "example" },
        },
        "vars": variables,
        "states": states,
    });
    if let (Some(start), Some(object)) = (loop_start(run), trace.as_object_mut()) {
        object.insert("loop".to_owned(), json!(start));
    }
    trace
}

/// Returns the index of the state to which the last one leads back.
fn loop_start(run: &Run) -> Option<usize> {
    let cycle = run.cycle?;
    let last = run.states.len().saturating_sub(1);
    let first = run.steps.get(cycle);
    // the state before the first transition of the cycle
    Some(first.map_or(last, |step| step.transition.saturating_sub(1)))
}

/// The step that led to a state.
fn meta(index: usize, run: &Run, machines: &[VerifiedMachine]) -> Value {
    let steps = run
        .steps
        .iter()
        .filter(|step| index > 0 && step.transition == index);
    let mut inputs = BTreeMap::new();
    let mut choices = Vec::new();
    let mut updates = Vec::new();
    for step in steps {
        inputs.extend(step.inputs.iter().cloned());
        let Some(machine) = machines.get(step.machine) else {
            continue;
        };
        choices.extend(choices_of(step));
        updates.extend(updates_of(step, &machine.specification));
    }
    json!({ "index": index, "inputs": inputs, "choices": choices, "updates": updates })
}

fn choices_of(step: &RunStep) -> Vec<Value> {
    let choices = step.choices.iter();
    let choices = choices.map(|it| {
        let values: BTreeMap<&String, &String> =
            it.values.iter().map(|(name, it)| (name, it)).collect();
        json!({ "index": it.index, "count": it.count, "values": values })
    });
    choices.collect()
}

fn updates_of(step: &RunStep, specification: &Specification) -> Vec<Value> {
    let updates = step.updates.iter().map(|update| {
        let rule = specification.rule_at(update.place);
        json!({
            "location": update.location,
            "rule": rule.map(|rule| rule.name.to_string()),
            "position": place_text(specification, update.place),
        })
    });
    updates.collect()
}

/// Several arguments are a tuple.
fn key(arguments: &[ExportedValue]) -> Value {
    match arguments {
        [argument] => value(argument),
        several => json!({ "#tup": several.iter().map(value).collect::<Vec<Value>>() }),
    }
}

fn value(named: &ExportedValue) -> Value {
    let list = |items: &[ExportedValue]| items.iter().map(value).collect::<Vec<Value>>();
    match named {
        ExportedValue::Undef => json!("undef"),
        ExportedValue::Bool(truth) => json!(truth),
        ExportedValue::Int(number) => json!({ "#bigint": number.to_string() }),
        ExportedValue::Text(text) => json!(text),
        ExportedValue::Tuple(items) => json!({ "#tup": list(items) }),
        ExportedValue::List(items) => json!(list(items)),
        ExportedValue::Set(items) => json!({ "#set": list(items) }),
        ExportedValue::Map(pairs) => {
            let pairs = pairs.iter().map(|(key, it)| json!([value(key), value(it)]));
            json!({ "#map": pairs.collect::<Vec<Value>>() })
        }
    }
}
