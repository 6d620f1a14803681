//! Entries of the log: the events of a run that are worth a line.

use std::sync::Arc;

use asmotion_component::{LOG_REPORT, NOTICE_REPORT, Time};
use asmotion_coordinator::{
    BAD_REPLY_REPORT, LOSSES_REPORT, UNFIT_REPORT, UNSENT_REPORT, VIOLATION_REPORT, ViolationRecord,
};
use asmotion_datum::{Datum, Sample};
use asmotion_runtime::Event;
use serde_json::{Value, json};

/// Limit on the length of a text in an entry, in characters.
const MAX_TEXT: usize = 400;
/// Limit on the number of values of a message that are shown.
const MAX_VALUES: usize = 12;
/// Fields of messages that are not shown.
const HIDDEN: &[&str] = &["header", "stamp", "plan", "covariance", "orientation"];

/// Makes an entry of an event; `None` if it is not worth a line. Messages on topics are recorded by
/// [`message`].
pub(crate) fn of(at: Time, event: &Event<'_>) -> Option<Arc<str>> {
    let entry = match event {
        Event::Injected { target, sample, .. } => {
            entry(at, "info", "message", target, &brief(*sample))
        }
        Event::Called {
            component,
            reference,
            operation,
            attempt,
            argument,
            ..
        } => {
            let repeated = if *attempt > 1 {
                format!(" (attempt {attempt})")
            } else {
                String::new()
            };
            let text = format!("{reference}.{operation} {}{repeated}", brief(*argument));
            entry(at, "info", "call", component, &text)
        }
        Event::Replied {
            component,
            reference,
            operation,
            result,
            ..
        } => {
            let (level, outcome) = match result {
                Ok(sample) => (
                    "info",
                    Some(brief(*sample))
                        .filter(|it| !it.is_empty())
                        .unwrap_or_else(|| "done".to_owned()),
                ),
                Err(error) => ("warning", error.to_string()),
            };
            let text = format!("{reference}.{operation} → {outcome}");
            entry(at, level, "reply", component, &text)
        }
        Event::LifeCycle {
            component,
            from,
            to,
        } => entry(
            at,
            "info",
            "life cycle",
            component,
            &format!("{from} → {to}"),
        ),
        Event::Fault { component, fault } => {
            entry(at, "error", "fault", component, &fault.to_string())
        }
        Event::Overrun { component, missed } => entry(
            at,
            "warning",
            "overrun",
            component,
            &format!("missed {missed} periods"),
        ),
        Event::Late {
            component,
            took,
            deadline,
        } => {
            let text = format!("a cycle took {took:.1?}, its deadline is {deadline:.1?}");
            entry(at, "warning", "late", component, &text)
        }
        Event::Denied { component, denied } => {
            entry(at, "warning", "denied", component, &denied.to_string())
        }
        Event::Dropped {
            component,
            port,
            to,
            total,
            reason,
        } => {
            let reason =
                reason.map_or_else(|| "the connection is full".to_owned(), ToString::to_string);
            let text = format!("{port} to {to}: {total} dropped, {reason}");
            entry(at, "warning", "dropped", component, &text)
        }
        Event::Property {
            component,
            property,
            value,
        } => entry(
            at,
            "info",
            "property",
            component,
            &format!("{property} = {value}"),
        ),
        Event::Report {
            component,
            kind,
            data,
        } => {
            let level = level_of(kind)?;
            let violation = data.to::<ViolationRecord>().ok();
            let violation = violation.filter(|_| *kind == VIOLATION_REPORT);
            let text = violation.map(|it| it.to_string()).unwrap_or_else(|| {
                data.as_text()
                    .map_or_else(|| data.to_string(), str::to_owned)
            });
            entry(at, level, kind, component, &text)
        }
        Event::Lost { count } => entry(
            at,
            "warning",
            "lost",
            "",
            &format!("{count} events were not observed"),
        ),
        Event::Cycle { .. } | Event::Published { .. } | Event::Answered { .. } => return None,
    };
    Some(entry)
}

/// Makes an entry of a message on a topic.
pub(crate) fn message(at: Time, component: &str, topic: &str, sample: &dyn Sample) -> Arc<str> {
    entry(
        at,
        "info",
        "message",
        component,
        &format!("{topic} {}", brief(sample)),
    )
}

/// Makes an entry of a command from a tab.
pub(crate) fn command(at: Time, client: &str, text: &str) -> Arc<str> {
    entry(at, "notice", "command", client, text)
}

/// The level of a report that is worth a line.
pub(crate) fn level_of(kind: &str) -> Option<&'static str> {
    Some(match kind {
        LOG_REPORT => "info",
        NOTICE_REPORT => "notice",
        LOSSES_REPORT | BAD_REPLY_REPORT | UNFIT_REPORT | UNSENT_REPORT => "warning",
        VIOLATION_REPORT => "error",
        _ => return None,
    })
}

/// Makes an entry.
pub(crate) fn entry(at: Time, level: &str, kind: &str, component: &str, text: &str) -> Arc<str> {
    let entry: Value = json!({
        "t": at.seconds(), "level": level, "kind": kind, "component": component, "text": shortened(text),
    });
    entry.to_string().into()
}

/// The content of a message in a few words: its values without times and frames, or its type if there are many.
fn brief(sample: &dyn Sample) -> String {
    match sample.to_datum() {
        Ok(datum) => brief_datum(&datum, sample.type_name()),
        Err(error) => error.to_string(),
    }
}

/// The content of a message of a type in a few words.
pub(crate) fn brief_datum(datum: &Datum, kind: &str) -> String {
    let mut values = Vec::new();
    collect(datum, &mut values);
    if values.len() > MAX_VALUES {
        return if kind.is_empty() {
            "(many values)".to_owned()
        } else {
            format!("({kind})")
        };
    }
    values.join(" ")
}

/// Adds the values of a datum, up to one more than are shown.
fn collect(datum: &Datum, values: &mut Vec<String>) {
    match datum {
        Datum::Record(entries) => {
            let entries = entries
                .iter()
                .filter(|(name, _)| !HIDDEN.contains(&&**name));
            entries.for_each(|(_, value)| collect(value, values));
        }
        Datum::List(elements) => elements
            .iter()
            .take(MAX_VALUES + 1)
            .for_each(|it| collect(it, values)),
        Datum::Numbers(numbers) => {
            let numbers = numbers.iter().take(MAX_VALUES + 1);
            numbers.for_each(|number| collect(&number, values));
        }
        Datum::Text(text) if text.is_empty() => {}
        Datum::Text(text) => values.push(text.clone()),
        Datum::Float(value) => values.push(format!("{}", (value * 1e4).round() / 1e4)),
        Datum::Null => {}
        Datum::Bool(_) | Datum::Int(_) | Datum::Bytes(_) => values.push(datum.to_string()),
    }
}

fn shortened(text: &str) -> String {
    match text.char_indices().nth(MAX_TEXT) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}
