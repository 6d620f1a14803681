//! Results of a verification as JSON.

use super::interrupt;
use super::words::{is_qualified, kind, machine_name, place_in, verdict};
use asmotion_lang::guards::PassedGuard;
use asmotion_verify::{AdviceKind, Incomplete, Note, Run, Verification, VerifiedMachine};
use serde_json::{Value, json};
use std::time::Duration;

/// The results as a JSON object.
pub fn verification(path: &str, verification: &Verification, time: Duration) -> Value {
    let machines = verification.machines.as_slice();
    let properties = verification.properties.iter().map(|property| {
        let word = verdict(&property.verdict);
        let word = if is_qualified(property, verification) {
            format!("{word}-unless-missed")
        } else {
            word.to_owned()
        };
        let place = property
            .place
            .map(|place| place_in(machines, property.machine, place));
        json!({
            "kind": kind(property.kind),
            "machine": machine_name(machines, property.machine),
            "name": property.name,
            "text": property.text,
            "place": place,
            "verdict": word,
            "undecided": property.notes.iter().find_map(undecided),
            "run": property.verdict.run().map(|run| run_json(run, machines)),
        })
    });
    let growing = verification.growing.iter().map(|it| {
        json!({
            "machine": machine_name(machines, it.machine),
            "location": it.location,
            "values": it.values,
            "count": it.count,
            "states": it.states,
            "place": place_in(machines, it.machine, it.place),
        })
    });
    let advice = verification.advice.iter().map(|advice| {
        json!({
            "kind": advice_kind(advice.kind),
            "text": advice.text,
            "place": place_in(machines, advice.machine, advice.place),
        })
    });
    let represented = verification.represented.iter().map(|it| {
        let values = it.values.iter();
        let values = values.map(|it| json!({ "value": it.value, "stands_for": it.stands_for }));
        json!({
            "machine": machine_name(machines, it.machine),
            "function": it.function,
            "values": values.collect::<Vec<Value>>(),
        })
    });
    json!({
        "type": "verification", "v": 1,
        "path": path,
        "properties": properties.collect::<Vec<Value>>(),
        "states": known(verification.states),
        "transitions": known(verification.transitions),
        "depth": verification.depth,
        "excluded": verification.excluded,
        "ends": known(verification.ends),
        "assumptions": verification.assumptions,
        "represented": represented.collect::<Vec<Value>>(),
        "advice": advice.collect::<Vec<Value>>(),
        "growing": growing.collect::<Vec<Value>>(),
        "left_out": verification.left_out,
        "symmetric": verification.symmetric,
        "has_left_out_steps": verification.has_left_out_steps,
        "expected_missed": verification.expected_missed,
        "incomplete": verification.incomplete.map(incomplete_word),
        "milliseconds": time.as_millis() as u64,
    })
}

fn advice_kind(kind: AdviceKind) -> &'static str {
    match kind {
        AdviceKind::UnreachedBranch => "unreached-branch",
        AdviceKind::UnusedValue => "unused-value",
        AdviceKind::TrivialUpdate => "trivial-update",
        AdviceKind::UnreadInput => "unread-input",
        AdviceKind::UnreachedCondition => "unreached-condition",
    }
}

/// A count; `None` if it is greater than the verification counts.
fn known(count: u64) -> Option<u64> {
    (count < u64::MAX).then_some(count)
}

/// The limit that was reached before a property was decided.
fn undecided(note: &Note) -> Option<&'static str> {
    if let Note::Undecided(reason) = note {
        return Some(incomplete_word(*reason));
    }
    None
}

fn incomplete_word(reason: Incomplete) -> &'static str {
    match reason {
        Incomplete::States => "states",
        Incomplete::Depth => "bound",
        Incomplete::Memory => "memory",
        Incomplete::Reserve => "reserve",
        Incomplete::Stopped if interrupt::has_occurred() => "interrupt",
        Incomplete::Stopped => "time",
    }
}

fn run_json(run: &Run, machines: &[VerifiedMachine]) -> Value {
    let object = |pairs: &[(String, String)]| {
        let pairs = pairs
            .iter()
            .map(|(key, value)| (key.clone(), Value::from(value.clone())));
        Value::Object(pairs.collect())
    };
    let guard = |guard: &PassedGuard| json!({ "text": guard.text, "holds": guard.holds, "values": object(&guard.values) });
    let steps = run.steps.iter().map(|step| {
        let choices = step.choices.iter().map(|choice| {
            let place = place_in(machines, step.machine, choice.place);
            let values = object(&choice.values);
            json!({ "index": choice.index, "count": choice.count, "place": place, "values": values })
        });
        let updates = step.updates.iter().map(|update| {
            json!({
                "location": update.location,
                "before": update.before,
                "after": update.after,
                "place": place_in(machines, step.machine, update.place),
                "guards": update.guards.iter().map(guard).collect::<Vec<Value>>(),
            })
        });
        json!({
            "machine": machine_name(machines, step.machine),
            "transition": step.transition,
            "inputs": object(&step.inputs),
            "choices": choices.collect::<Vec<Value>>(),
            "messages": step.messages,
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
