//! Differences and explanations in words.

use asmotion_coordinator::{ChoiceRecord, ReadLocation};
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
    if let Some(what) = subject(difference) {
        lines.push(("what", what));
    }
    if let Some((recorded, replayed)) = sides(difference) {
        lines.push(("recorded", recorded));
        lines.push(("replay", replayed));
    }
    let guards = difference.guards.iter();
    lines.extend(guards.map(|guard| ("because", show::guard(guard))));
    if difference.is_altered && difference.kind != DifferenceKind::Missing {
        let text = "it was changed after the run: its hash is not that of its content";
        lines.push(("record", text.to_owned()));
    }
    lines
}

/// What is different.
fn subject(difference: &StepDifference) -> Option<String> {
    Some(match &difference.kind {
        DifferenceKind::Altered if difference.is_altered => return None,
        DifferenceKind::Altered => {
            "a part of the record that this version of asmotion does not know".to_owned()
        }
        DifferenceKind::Unfit { texts } => {
            let texts = texts.join("`, `");
            format!("`{texts}` does not fit the recorded specification")
        }
        DifferenceKind::Number { .. } => "number of the step".to_owned(),
        DifferenceKind::Begin { location, .. } => {
            format!("`{location}` at the beginning of the machine")
        }
        DifferenceKind::Update { location, .. } => format!("update of `{location}`"),
        DifferenceKind::Fault { .. } => "failure".to_owned(),
        DifferenceKind::Rule { .. } => "rule that makes the step".to_owned(),
        DifferenceKind::Violation { .. } => "violated property".to_owned(),
        DifferenceKind::Extended { .. } => "new element".to_owned(),
        DifferenceKind::Sent { .. } => "message sent".to_owned(),
        DifferenceKind::Read { .. } => "input read".to_owned(),
        DifferenceKind::Choice { .. } => "choice".to_owned(),
        DifferenceKind::Missing => {
            "steps are missing, and the recording counts none as lost".to_owned()
        }
    })
}

/// What is recorded, and what the replay has instead.
fn sides(difference: &StepDifference) -> Option<(String, String)> {
    let of_read = |read: &ReadLocation| format!("{} = {}", read.location, read.value);
    let of_choice = |it: &ChoiceRecord| format!("candidate {} of {}", it.index + 1, it.of);
    match &difference.kind {
        DifferenceKind::Altered | DifferenceKind::Unfit { .. } | DifferenceKind::Missing => None,
        DifferenceKind::Number { replayed } => {
            Some((difference.number.to_string(), replayed.to_string()))
        }
        DifferenceKind::Begin {
            recorded, replayed, ..
        } => Some((recorded.clone(), replayed.clone())),
        DifferenceKind::Update {
            recorded, replayed, ..
        } => {
            let (recorded, replayed) = (recorded.as_ref(), replayed.as_ref());
            Some((written(recorded, replayed), written(replayed, recorded)))
        }
        DifferenceKind::Rule { recorded, replayed } => {
            let rule = |it: &Option<String>| match it {
                Some(safe) => format!("the safe rule `{safe}`"),
                None => "the main rule".to_owned(),
            };
            Some((rule(recorded), rule(replayed)))
        }
        DifferenceKind::Fault { recorded, replayed }
        | DifferenceKind::Violation { recorded, replayed }
        | DifferenceKind::Extended { recorded, replayed }
        | DifferenceKind::Sent { recorded, replayed } => Some((
            shown(recorded, String::clone),
            shown(replayed, String::clone),
        )),
        DifferenceKind::Read { recorded, replayed } => {
            Some((shown(recorded, of_read), shown(replayed, of_read)))
        }
        DifferenceKind::Choice { recorded, replayed } => {
            Some((shown(recorded, of_choice), shown(replayed, of_choice)))
        }
    }
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

fn shown<T>(side: &Option<T>, text: impl Fn(&T) -> String) -> String {
    side.as_ref().map_or_else(|| "none".to_owned(), text)
}
