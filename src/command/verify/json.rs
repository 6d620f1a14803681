//! Results of a verification as JSON.

use super::words::{kind, place_text, verdict};
use asmotion_lang::Specification;
use asmotion_verify::{Incomplete, Run, Verification};
use serde_json::{Value, json};
use std::time::Duration;

/// The results as a JSON object.
pub fn verification(path: &str, verification: &Verification, time: Duration) -> Value {
    let specification = &verification.specification;
    let properties = verification.properties.iter().map(|property| {
        let place = property.place.map(|place| place_text(specification, place));
        json!({
            "kind": kind(property.kind),
            "name": property.name,
            "text": property.text,
            "place": place,
            "verdict": verdict(&property.verdict),
            "run": property.verdict.run().map(|run| run_json(run, specification)),
        })
    });
    json!({
        "type": "verification", "v": 1,
        "path": path,
        "properties": properties.collect::<Vec<Value>>(),
        "states": verification.states,
        "transitions": verification.transitions,
        "depth": verification.depth,
        "excluded": verification.excluded,
        "assumptions": verification.assumptions,
        "incomplete": verification.incomplete.map(incomplete_word),
        "milliseconds": time.as_millis() as u64,
    })
}

fn incomplete_word(reason: Incomplete) -> &'static str {
    match reason {
        Incomplete::States => "states",
        Incomplete::Depth => "bound",
        Incomplete::Memory => "memory",
        Incomplete::Stopped => "time",
    }
}

fn run_json(run: &Run, specification: &Specification) -> Value {
    let object = |pairs: &[(String, String)]| {
        let pairs = pairs
            .iter()
            .map(|(key, value)| (key.clone(), Value::from(value.clone())));
        Value::Object(pairs.collect())
    };
    let steps = run.steps.iter().map(|step| {
        let choices = step.choices.iter().map(|(index, count, place)| {
            json!({ "index": index, "count": count, "place": place_text(specification, *place) })
        });
        let updates = step.updates.iter().map(|update| {
            json!({
                "location": update.location,
                "before": update.before,
                "after": update.after,
                "place": place_text(specification, update.place),
            })
        });
        json!({
            "inputs": object(&step.inputs),
            "choices": choices.collect::<Vec<Value>>(),
            "updates": updates.collect::<Vec<Value>>(),
            "fault": step.fault.as_ref().map(|fault| fault.message.clone()),
        })
    });
    json!({
        "initial": object(&run.initial),
        "steps": steps.collect::<Vec<Value>>(),
        "cycle": run.cycle,
        "inputs": object(&run.inputs),
    })
}
