//! Prints the results of replays as JSON.

use std::time::Duration;

use asmotion_lang::guards::PassedGuard;
use asmotion_recording::{DifferenceKind, StepDifference, WrittenValue};
use serde_json::{Map, Value, json};

use super::console::Totals;
use super::outcome::{CoordinatorOutcome, Explained, ReachedState, RecordingOutcome};
use super::words;
use crate::terminal::TerminalOutput;

/// Prints an object for each command, each coordinator and each unusable recording, and one for the result.
pub fn print(outcomes: &[RecordingOutcome], wall: Duration, terminal: &mut TerminalOutput) {
    for outcome in outcomes {
        let path = outcome.path.display().to_string();
        if let Some(failure) = &outcome.failure {
            terminal.result(json!({
                "type": "recording", "v": 1, "path": path, "result": outcome.verdict().word(), "reason": failure,
            }));
        }
        for (at, command) in &outcome.commands {
            terminal.result(json!({
                "type": "command", "v": 1, "path": path, "time_s": at.seconds(), "number": command.number, "client": command.client,
                "tab": command.tab, "login": command.login, "text": command.text, "outcome": command.outcome,
                "reason": command.reason,
            }));
        }
        for (name, one) in &outcome.coordinators {
            terminal.result(coordinator(&path, name, one, outcome));
        }
    }
    let totals = Totals::of(outcomes);
    let (time, wall) = (totals.time_ns as f64 / 1e9, wall.as_secs_f64());
    terminal.result(json!({
        "type": "replay", "v": 1, "result": totals.verdict.word(), "recordings": outcomes.len(),
        "coordinators": totals.coordinators, "steps": totals.steps, "time_s": time, "wall_s": wall,
        "speed": time / wall.max(1e-9),
    }));
}

fn coordinator(
    path: &str,
    name: &str,
    one: &CoordinatorOutcome,
    outcome: &RecordingOutcome,
) -> Value {
    let counts = &one.counts;
    let notes = one.notes.iter();
    let notes = notes.map(|(text, number)| json!({ "text": text, "step": number }));
    json!({
        "type": "coordinator", "v": 1, "path": path, "component": name, "specification": one.specification,
        "result": one.verdict().word(), "reason": one.reason(), "steps": counts.compared, "failed": counts.failed,
        "machines": counts.machines, "not_compared": counts.not_compared, "lost": one.lost,
        "complete": outcome.missing().is_none(), "incomplete": outcome.missing(),
        "time_s": counts.last_ns as f64 / 1e9, "difference": one.difference.as_ref().map(difference),
        "notes": notes.collect::<Vec<_>>(), "state": one.state.as_ref().map(state),
        "explanation": one.explanation.as_ref().map(explanation),
    })
}

fn difference(difference: &StepDifference) -> Value {
    let lines = words::difference(difference).into_iter();
    let text = lines.map(|(label, text)| format!("{label}: {text}"));
    let mut shown = json!({
        "step": difference.number, "time_s": difference.time_ns as f64 / 1e9, "cause": difference.cause,
        "altered": difference.is_altered, "text": text.collect::<Vec<_>>().join("\n"),
    });
    if let DifferenceKind::Update {
        location,
        recorded,
        replayed,
    } = &difference.kind
    {
        shown["location"] = location.as_str().into();
        shown["recorded"] = written(recorded.as_ref());
        shown["replayed"] = written(replayed.as_ref());
    }
    shown
}

fn written(update: Option<&WrittenValue>) -> Value {
    update.map_or(
        Value::Null,
        |it| json!({ "before": it.before, "after": it.after, "place": it.place, "rule": it.rule }),
    )
}

fn state(state: &ReachedState) -> Value {
    let object = |pairs: &mut dyn Iterator<Item = (&String, &String)>| {
        let pairs = pairs.map(|(name, value)| (name.clone(), Value::from(value.as_str())));
        Value::Object(pairs.collect::<Map<_, _>>())
    };
    let locations = object(&mut state.locations.iter().map(|(name, value)| (name, value)));
    json!({
        "step": state.number, "time_s": state.time_ns as f64 / 1e9, "state": locations,
        "inputs": object(&mut state.inputs.iter()),
    })
}

fn explanation(explained: &Explained) -> Value {
    match explained {
        Explained::Written(writer) => {
            let (path, line, column) = &writer.place;
            let guards = writer.guards.iter().map(guard);
            let read = writer.read.iter();
            let read = read.map(|it| json!({ "location": it.location, "value": it.value }));
            json!({
                "kind": "written", "location": writer.location, "value": writer.after, "before": writer.before,
                "step": writer.number, "time_s": writer.time_ns as f64 / 1e9, "cause": writer.cause,
                "text": writer.text, "rule": writer.rule, "safe_rule": writer.safe_rule, "path": path, "line": line, "column": column,
                "guards": guards.collect::<Vec<_>>(), "read": read.collect::<Vec<_>>(),
            })
        }
        Explained::Input(change) => json!({
            "kind": "input", "location": change.location, "value": change.value, "before": change.before,
            "step": change.number, "time_s": change.time_ns as f64 / 1e9, "cause": change.cause,
        }),
        Explained::Initial(location, value) => {
            json!({ "kind": "initial", "location": location, "value": value })
        }
    }
}

fn guard(guard: &PassedGuard) -> Value {
    let values = guard.values.iter();
    let values = values.map(|(name, value)| (name.clone(), Value::from(value.as_str())));
    json!({ "text": guard.text, "holds": guard.holds, "values": values.collect::<Map<_, _>>() })
}
