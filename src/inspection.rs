//! Formats the internal state that components describe, for the tools that show components.

use asmotion_coordinator::CoordinatorStatus;
use asmotion_datum::Datum;
use std::collections::BTreeMap;

use asmotion_story::brief::brief;

/// The control state of a coordinator, as in `mode = FOLLOWING`, or those of its agents, as in `IDLE ×2, RUN ×1`; `None` for other
/// components.
pub fn control_state(inspection: &[(String, Datum)]) -> Option<String> {
    let status = CoordinatorStatus::of(inspection)?;
    match status.control_state() {
        Some((location, value)) => Some(format!("{location} = {value}")),
        None => status.control_states(),
    }
}

/// The entries of a description as pairs of name and text. A coordinator's come as its control states, its last update
/// set, what its next steps depend on, and the properties that it violates or that are not watched.
pub fn entries(inspection: &[(String, Datum)]) -> Vec<(String, String)> {
    match CoordinatorStatus::of(inspection) {
        Some(status) => of_coordinator(&status),
        None => inspection
            .iter()
            .map(|(name, value)| (name.clone(), brief(value)))
            .collect(),
    }
}

fn of_coordinator(status: &CoordinatorStatus) -> Vec<(String, String)> {
    let entry = |name: &str, text: String| (name.to_owned(), text);
    let mut entries = vec![entry("state", equations(&status.state, "="))];
    if let Some(last) = &status.last_update {
        let updates = equations(&last.updates, ":=");
        let text = format!("{updates}  (step {}, {:.2} s)", last.step, last.at_s);
        entries.push(entry("updates", text));
    }
    entries.push(entry("reads", equations(&status.read, "=")));
    if !status.calls.is_empty() {
        entries.push(entry("waits for", status.calls.join(", ")));
    }
    if !status.silent.is_empty() {
        let silent: Vec<&str> = status.silent.iter().map(String::as_str).collect();
        entries.push(entry("no message", silent.join(", ")));
    }
    if !status.waiting_events.is_empty() {
        let counts = status.waiting_events.iter();
        let counts: Vec<String> = counts
            .map(|(event, count)| format!("{event} ×{count}"))
            .collect();
        entries.push(entry("queued", counts.join(", ")));
    }
    for (property, steps) in &status.violated {
        let times = if *steps == 1 { "step" } else { "steps" };
        entries.push(entry("violated", format!("{property} by {steps} {times}")));
    }
    for (property, reason) in &status.unwatched {
        entries.push(entry("unwatched", format!("{property}: {reason}")));
    }
    entries
}

/// Locations with their values on one line.
fn equations(values: &BTreeMap<String, String>, sign: &str) -> String {
    if values.is_empty() {
        return "-".to_owned();
    }
    let values = values.iter();
    let shown: Vec<String> = values
        .map(|(location, value)| format!("{location} {sign} {value}"))
        .collect();
    shown.join(", ")
}
