//! Entries of the log: the events of a run that are worth a line.

use std::sync::Arc;

use asmotion_component::{Fault, LOG_REPORT, NOTICE_REPORT, Time};
use asmotion_coordinator::{
    BAD_REPLY_REPORT, LOSSES_REPORT, UNFIT_REPORT, UNSENT_REPORT, VIOLATION_REPORT, ViolationRecord,
};
use asmotion_datum::{Datum, Sample};
use asmotion_remote::{CommandOutcome, CommandRecord};
use asmotion_runtime::Event;
use serde::Deserialize;
use serde_json::{Value, json};

/// Kind of the entries of commands.
const COMMAND: &str = "command";
/// Limit on the length of a text in an entry, in characters.
const MAX_TEXT: usize = 400;
/// Limit on the number of values of a message that are shown.
const MAX_VALUES: usize = 12;
/// Fields of messages that are not shown.
const HIDDEN: &[&str] = &["header", "stamp", "plan", "covariance", "orientation"];

/// The level of an entry, the least first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum LogLevel {
    #[default]
    Info,
    Notice,
    Warning,
    Error,
}

impl LogLevel {
    /// Its name in the messages to a tab.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Info => "info",
            Self::Notice => "notice",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

/// An entry of the log.
#[derive(Clone)]
pub(crate) struct LogEntry {
    pub level: LogLevel,
    /// Kind, component and text in lower case, which filters search.
    searched: Arc<str>,
    pub json: Arc<str>,
}

/// The part of the log that a tab asks for.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LogFilter {
    /// Number of the filter, which frames repeat.
    pub number: u64,
    /// The least level.
    #[serde(default)]
    pub level: LogLevel,
    /// Words that must occur in kind, component or text, and `!word` for words that must not; whatever their case.
    #[serde(default)]
    pub words: Vec<String>,
}

impl LogFilter {
    /// Returns the filter with its words in lower case, as entries are searched.
    pub(crate) fn lowercase(mut self) -> Self {
        for word in &mut self.words {
            *word = word.to_lowercase();
        }
        self
    }

    /// Returns whether an entry passes.
    pub(crate) fn takes(&self, entry: &LogEntry) -> bool {
        let passes = |word: &String| match word.strip_prefix('!') {
            Some("") => true,
            Some(word) => !entry.searched.contains(word),
            None => entry.searched.contains(&**word),
        };
        entry.level >= self.level && self.words.iter().all(passes)
    }
}

/// Makes an entry of an event; `None` if it is not worth a line. Messages on topics are recorded by
/// [`message`].
pub(crate) fn of(at: Time, event: &Event<'_>) -> Option<LogEntry> {
    let entry = match event {
        Event::Injected { target, sample, .. } => {
            entry(at, LogLevel::Info, "message", target, &brief(*sample))
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
            entry(at, LogLevel::Info, "call", component, &text)
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
                    LogLevel::Info,
                    Some(brief(*sample))
                        .filter(|it| !it.is_empty())
                        .unwrap_or_else(|| "done".to_owned()),
                ),
                Err(error) => (LogLevel::Warning, error.to_string()),
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
            LogLevel::Info,
            "life cycle",
            component,
            &format!("{from} → {to}"),
        ),
        Event::Fault { component, fault } => {
            entry(at, LogLevel::Error, "fault", component, &fault.to_string())
        }
        Event::Overrun { component, missed } => entry(
            at,
            LogLevel::Warning,
            "overrun",
            component,
            &Fault::Overrun { missed: *missed }.to_string(),
        ),
        Event::Late {
            component,
            took,
            deadline,
        } => {
            let text = format!("a cycle took {took:.1?}, its deadline is {deadline:.1?}");
            entry(at, LogLevel::Warning, "late", component, &text)
        }
        Event::Denied { component, denied } => entry(
            at,
            LogLevel::Warning,
            "denied",
            component,
            &denied.to_string(),
        ),
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
            entry(at, LogLevel::Warning, "dropped", component, &text)
        }
        Event::Property {
            component,
            property,
            value,
        } => entry(
            at,
            LogLevel::Info,
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
            LogLevel::Warning,
            "lost",
            "",
            &format!("{count} events were not observed"),
        ),
        Event::Cycle { .. } | Event::Published { .. } | Event::Answered { .. } => return None,
    };
    Some(entry)
}

/// Makes an entry of a message on a topic.
pub(crate) fn message(at: Time, component: &str, topic: &str, sample: &dyn Sample) -> LogEntry {
    entry(
        at,
        LogLevel::Info,
        "message",
        component,
        &format!("{topic} {}", brief(sample)),
    )
}

/// Makes an entry of a command from outside, or of its outcome.
pub(crate) fn command(at: Time, record: &CommandRecord) -> LogEntry {
    let level = match record.outcome {
        CommandOutcome::Asked | CommandOutcome::Done => LogLevel::Notice,
        CommandOutcome::Refused | CommandOutcome::Unknown => LogLevel::Warning,
    };
    entry(at, level, COMMAND, &record.origin(), &record.words())
}

/// The level of a report that is worth a line.
pub(crate) fn level_of(kind: &str) -> Option<LogLevel> {
    Some(match kind {
        LOG_REPORT => LogLevel::Info,
        NOTICE_REPORT => LogLevel::Notice,
        LOSSES_REPORT | BAD_REPLY_REPORT | UNFIT_REPORT | UNSENT_REPORT => LogLevel::Warning,
        VIOLATION_REPORT => LogLevel::Error,
        _ => return None,
    })
}

/// Makes an entry.
pub(crate) fn entry(
    at: Time,
    level: LogLevel,
    kind: &str,
    component: &str,
    text: &str,
) -> LogEntry {
    let text = shortened(text);
    let searched = format!("{kind} {component} {text}").to_lowercase();
    let entry: Value = json!({
        "t": at.seconds(), "level": level.name(), "kind": kind, "component": component, "text": text,
    });
    LogEntry {
        level,
        searched: searched.into(),
        json: entry.to_string().into(),
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_filter_takes_a_level_and_words_whatever_their_case() {
        let entry = entry(
            Time::ZERO,
            LogLevel::Warning,
            "reply",
            "Rover/Nav",
            "plan → Late",
        );
        let takes = |level, words: &[&str]| {
            let words = words.iter().map(|it| (*it).to_owned()).collect();
            let number = 1;
            let filter = LogFilter {
                number,
                level,
                words,
            };
            filter.lowercase().takes(&entry)
        };
        assert!(takes(LogLevel::Info, &[]) && takes(LogLevel::Warning, &["ROVER", "late"]));
        assert!(!takes(LogLevel::Error, &[]) && !takes(LogLevel::Info, &["arm"]));
        assert!(
            takes(LogLevel::Info, &["!arm", "!"]) && !takes(LogLevel::Info, &["nav", "!Reply"])
        );
    }
}
