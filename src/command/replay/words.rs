//! Differences and explanations in words.

use asmotion_recording::{DifferenceKind, StepDifference, WrittenValue};

use crate::show;

/// A time of the run, as in `10.650 s`.
pub fn seconds(time_ns: i64) -> String {
    format!("{:.3} s", time_ns as f64 / 1e9)
}

/// The cause of a step.
pub fn cause(cause: &[String]) -> String {
    match cause {
        [] => "its time".to_owned(),
        causes => causes.join(", "),
    }
}

/// A step, as in `step 213 at 10.650 s`.
pub fn step(number: u64, time_ns: i64) -> String {
    format!("step {number} at {}", seconds(time_ns))
}

/// A line about a difference: its label, and its text.
pub type Line = (&'static str, String);

/// The difference in a few lines.
pub fn difference(difference: &StepDifference) -> Vec<Line> {
    let mut lines = vec![("cause", cause(&difference.cause))];
    let mut both = |what: String, recorded: String, replayed: String| {
        lines.push(("what", what));
        lines.push(("recorded", recorded));
        lines.push(("replay", replayed));
    };
    match &difference.kind {
        DifferenceKind::Altered if difference.is_altered => {}
        DifferenceKind::Altered => lines.push((
            "what",
            "a part of the record that this version of asmotion does not know".to_owned(),
        )),
        DifferenceKind::Unfit { texts } => lines.push((
            "what",
            format!(
                "`{}` does not fit the recorded specification",
                texts.join("`, `")
            ),
        )),
        DifferenceKind::Number { replayed } => both(
            "number of the step".to_owned(),
            difference.number.to_string(),
            replayed.to_string(),
        ),
        DifferenceKind::Begin {
            location,
            recorded,
            replayed,
        } => both(
            format!("`{location}` at the beginning of the machine"),
            recorded.clone(),
            replayed.clone(),
        ),
        DifferenceKind::Update {
            location,
            recorded,
            replayed,
        } => both(
            format!("update of `{location}`"),
            written(recorded.as_ref(), replayed.as_ref()),
            written(replayed.as_ref(), recorded.as_ref()),
        ),
        DifferenceKind::Fault { recorded, replayed } => both(
            "failure".to_owned(),
            fault(recorded.as_ref()),
            fault(replayed.as_ref()),
        ),
        DifferenceKind::Extended { recorded, replayed } => {
            both(
                "new element".to_owned(),
                or_none(recorded),
                or_none(replayed),
            );
        }
        DifferenceKind::Sent { recorded, replayed } => {
            both(
                "message sent".to_owned(),
                or_none(recorded),
                or_none(replayed),
            );
        }
        DifferenceKind::Read { recorded, replayed } => {
            let shown = |read: &Option<asmotion_coordinator::ReadLocation>| {
                or_none(
                    &read
                        .as_ref()
                        .map(|it| format!("{} = {}", it.location, it.value)),
                )
            };
            both("input read".to_owned(), shown(recorded), shown(replayed));
        }
        DifferenceKind::Choice { recorded, replayed } => {
            let shown = |choice: &Option<asmotion_coordinator::ChoiceRecord>| {
                let text = choice.map(|it| format!("candidate {} of {}", it.index + 1, it.of));
                or_none(&text)
            };
            both("choice".to_owned(), shown(recorded), shown(replayed));
        }
        DifferenceKind::Missing => lines.push((
            "what",
            "steps are missing, and the recording counts none as lost".to_owned(),
        )),
    }
    let guards = difference.guards.iter();
    lines.extend(guards.map(|guard| ("because", show::guard(guard))));
    if difference.is_altered && difference.kind != DifferenceKind::Missing {
        let text = "it was changed after the run: its hash is not that of its content";
        lines.push(("record", text.to_owned()));
    }
    lines
}

/// An update; without one, the value that the location keeps.
fn written(update: Option<&WrittenValue>, other: Option<&WrittenValue>) -> String {
    match (update, other) {
        (Some(update), _) => {
            let rule = update.rule.as_ref().map(|rule| format!("{rule}, "));
            let rule = rule.unwrap_or_default();
            let WrittenValue {
                before,
                after,
                place,
                ..
            } = update;
            format!("{after} (was {before}), by {rule}{place}")
        }
        (None, Some(other)) => format!("no update: it remains {}", other.before),
        (None, None) => "no update".to_owned(),
    }
}

fn fault(fault: Option<&String>) -> String {
    fault.cloned().unwrap_or_else(|| "none".to_owned())
}

fn or_none(text: &Option<String>) -> String {
    text.clone().unwrap_or_else(|| "none".to_owned())
}
