//! Log entries of a recorded run, from the records of its events and calls.

use std::borrow::Cow;

use asmotion_component::{Fault, Time};
use asmotion_coordinator::{VIOLATION_REPORT, ViolationRecord};
use asmotion_datum::Datum;

use crate::log_entry::{LogEntry, LogLevel, brief_datum, entry, level_of};

/// An entry that is not in a list yet.
pub(super) struct NewEntry {
    pub level: LogLevel,
    kind: String,
    component: String,
    pub text: String,
}

impl NewEntry {
    pub fn new(
        level: LogLevel,
        kind: impl Into<String>,
        component: impl Into<String>,
        text: impl Into<String>,
    ) -> Self {
        Self {
            level,
            kind: kind.into(),
            component: component.into(),
            text: text.into(),
        }
    }

    pub fn entry(&self, at: Time) -> LogEntry {
        entry(at, self.level, &self.kind, &self.component, &self.text)
    }
}

fn text<'d>(record: &'d Datum, member: &str) -> Cow<'d, str> {
    match record.get(member) {
        Some(Cow::Borrowed(Datum::Text(text))) => Cow::Borrowed(text),
        Some(value) if value.is_null() => Cow::Borrowed(""),
        Some(value) => Cow::Owned(
            value
                .as_text()
                .map_or_else(|| value.to_string(), str::to_owned),
        ),
        None => Cow::Borrowed(""),
    }
}

/// The entry of an event; `None` if it is not worth a line.
pub(super) fn of_event(record: &Datum) -> Option<NewEntry> {
    let (kind, component) = (text(record, "kind"), text(record, "component"));
    let member = |name: &str| text(record, name);
    let own = || member("text").into_owned();
    let (level, name, words) = match &*kind {
        "life_cycle" => (
            LogLevel::Info,
            "life cycle",
            format!("{} → {}", member("from"), member("to")),
        ),
        "fault" => (LogLevel::Error, "fault", own()),
        "overrun" => (
            LogLevel::Warning,
            "overrun",
            Fault::Overrun {
                missed: member("count").parse().unwrap_or_default(),
            }
            .to_string(),
        ),
        "late" => {
            let (took, deadline) = (member("took_s"), member("deadline_s"));
            (
                LogLevel::Warning,
                "late",
                format!("a cycle took {took} s, its deadline is {deadline} s"),
            )
        }
        "denied" => (LogLevel::Warning, "denied", own()),
        "dropped" => {
            let (port, to, count) = (member("port"), member("to"), member("count"));
            let reason = member("text");
            let reason = if reason.is_empty() {
                "the connection is full"
            } else {
                &*reason
            };
            (
                LogLevel::Warning,
                "dropped",
                format!("{port} to {to}: {count} dropped, {reason}"),
            )
        }
        "property" => (
            LogLevel::Info,
            "property",
            format!("{} = {}", member("property"), member("value")),
        ),
        "lost" => (
            LogLevel::Warning,
            "lost",
            format!("{} events were not observed", member("count")),
        ),
        report => {
            let level = level_of(report)?;
            let words = match violation(report, record) {
                Some(violation) => violation,
                None if own().is_empty() => member("data").into_owned(),
                None => own(),
            };
            (level, report, words)
        }
    };
    Some(NewEntry::new(level, name, component, words))
}

/// A violated property in words; `None` for another report.
fn violation(report: &str, record: &Datum) -> Option<String> {
    let data = record.get("data").filter(|_| report == VIOLATION_REPORT)?;
    Some(data.to::<ViolationRecord>().ok()?.to_string())
}

/// The entry of a call or of its end. `caller` is `Component.reference.operation`.
pub(super) fn of_call(caller: &str, record: &Datum) -> Option<NewEntry> {
    let (rest, operation) = caller.rsplit_once('.')?;
    let (component, reference) = rest.rsplit_once('.')?;
    let brief = |member: &str| {
        let value = record.get(member);
        value.map_or_else(String::new, |value| brief_datum(&value, ""))
    };
    let (level, kind, words) = match &*text(record, "phase") {
        "call" => {
            let attempt = record
                .get("attempt")
                .and_then(|it| it.as_int())
                .unwrap_or(1);
            let repeated = if attempt > 1 {
                format!(" (attempt {attempt})")
            } else {
                String::new()
            };
            (
                LogLevel::Info,
                "call",
                format!("{}{repeated}", brief("argument")),
            )
        }
        "reply" => {
            let result = brief("result");
            (
                LogLevel::Info,
                "reply",
                format!("→ {}", if result.is_empty() { "done" } else { &result }),
            )
        }
        _ => (
            LogLevel::Warning,
            "reply",
            format!("→ {}", text(record, "error")),
        ),
    };
    let words = format!("{reference}.{operation} {words}");
    Some(NewEntry::new(level, kind, component, words))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(entry: Option<NewEntry>) -> String {
        let entry = entry.expect("an entry");
        let NewEntry {
            level,
            kind,
            component,
            text,
        } = entry;
        format!("{} {kind} {component}: {text}", level.name())
    }

    #[test]
    fn events_are_told_as_those_of_a_running_system() {
        let record = |members: &[(&'static str, Datum)]| Datum::record(members.to_vec());
        let fault = record(&[
            ("kind", Datum::text("fault")),
            ("component", Datum::text("Arm/Driver")),
            ("text", Datum::text("no motor")),
        ]);
        assert_eq!(said(of_event(&fault)), "error fault Arm/Driver: no motor");
        let dropped = record(&[
            ("kind", Datum::text("dropped")),
            ("component", Datum::text("A")),
            ("port", Datum::text("scan")),
            ("to", Datum::text("B.scan")),
            ("count", Datum::Int(3)),
            ("text", Datum::Null),
        ]);
        let words = "warning dropped A: scan to B.scan: 3 dropped, the connection is full";
        assert_eq!(said(of_event(&dropped)), words);
        assert!(of_event(&record(&[("kind", Datum::text("unknown"))])).is_none());
        let violation = ViolationRecord {
            step: 7,
            kind: "CTLSPEC".to_owned(),
            property: "ag(n < 20)".to_owned(),
            ..ViolationRecord::default()
        };
        let violated = record(&[
            ("kind", Datum::text(VIOLATION_REPORT)),
            ("component", Datum::text("A")),
            ("data", Datum::of(&violation).expect("a datum")),
        ]);
        let words = "error asm/Violation A: step 7 violates CTLSPEC `ag(n < 20)`";
        assert_eq!(said(of_event(&violated)), words);
        let call = record(&[
            ("phase", Datum::text("call")),
            ("attempt", Datum::Int(2)),
            ("argument", Datum::record([("x", Datum::Float(1.5))])),
        ]);
        let words = "info call Rover/Nav: planner.plan 1.5 (attempt 2)";
        assert_eq!(said(of_call("Rover/Nav.planner.plan", &call)), words);
        let failed = record(&[
            ("phase", Datum::text("fault")),
            ("error", Datum::text("NO_PATH")),
        ]);
        let words = "warning reply Nav: planner.plan → NO_PATH";
        assert_eq!(said(of_call("Nav.planner.plan", &failed)), words);
    }
}
