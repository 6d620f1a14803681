//! Trace of a run, one event per line; equal runs give equal bytes.
//!
//! Steps of coordinators are written in full. Of a message, the trace contains the CRC-32 of its CBOR encoding, so that
//! a map takes one line like any other message. Cycles without effect are omitted, and steps that write nothing.

mod replay;

pub use replay::{RecordedRun, RecordedUpdates, ReplayError, is_run_trace, recorded_run};

use asmotion_component::{CallError, Time};
use asmotion_coordinator::{
    FAILED_STEP_REPORT, RECORDED_CYCLE_REPORT, STEP_REPORT, StepRecord, VIOLATION_REPORT,
    ViolationRecord,
};
use asmotion_datum::{Datum, Sample, cbor, json};
use asmotion_runtime::Event;
use std::fmt::Write;

/// Writes events as lines.
#[derive(Debug, Default)]
pub struct MissionTrace {
    text: String,
}

impl MissionTrace {
    /// Creates an empty trace.
    pub fn new() -> Self {
        Self::default()
    }

    /// All lines so far.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Takes the lines so far out of the trace.
    pub fn take_text(&mut self) -> String {
        std::mem::take(&mut self.text)
    }

    /// Records an event.
    pub fn note(&mut self, at: Time, event: &Event<'_>) {
        let line = match event {
            Event::Cycle { .. } => return,
            // a run has the same trace whether it is recorded or not
            Event::Report { kind, .. } if *kind == RECORDED_CYCLE_REPORT => return,
            // initial properties contain file paths, which differ between machines
            Event::Property { .. } if at == Time::ZERO => return,
            Event::Published {
                component,
                port,
                sequence,
                sample,
                ..
            } => {
                format!("publish {component}.{port} #{sequence} {}", print(*sample))
            }
            Event::Injected {
                target: place,
                sample,
                ..
            } => format!("inject {place} {}", print(*sample)),
            Event::Called {
                component,
                reference,
                operation,
                call,
                attempt,
                argument,
            } => {
                let argument = print(*argument);
                format!(
                    "call {component}.{reference}.{operation} {} attempt {attempt} {argument}",
                    call.0
                )
            }
            Event::Answered {
                component,
                service,
                operation,
                caller,
                result,
            } => {
                let result = outcome(*result);
                format!("answer {component}.{service}.{operation} to {caller} {result}")
            }
            Event::Replied {
                component,
                reference,
                operation,
                call,
                result,
            } => {
                let result = outcome(*result);
                format!(
                    "reply {component}.{reference}.{operation} {} {result}",
                    call.0
                )
            }
            Event::LifeCycle {
                component,
                from,
                to,
            } => format!("life {component} {from:?} {to:?}"),
            Event::Fault { component, fault } => format!("fault {component} {fault}"),
            Event::Overrun { component, missed } => format!("overrun {component} {missed}"),
            Event::Late {
                component,
                took,
                deadline,
            } => format!(
                "late {component} {} {}",
                took.as_nanos(),
                deadline.as_nanos()
            ),
            Event::Denied { component, denied } => format!("denied {component} {denied}"),
            Event::Dropped {
                component,
                port,
                to,
                total,
                reason,
            } => {
                let reason = reason.map(|reason| format!(" {reason}"));
                let reason = reason.unwrap_or_default();
                format!("dropped {component}.{port} {to} {total}{reason}")
            }
            Event::Property {
                component,
                property,
                value,
            } => {
                format!("property {component}.{property} {}", written(value))
            }
            Event::Report {
                component,
                kind,
                data: what,
            } => report(component, kind, what),
            Event::Lost { count } => format!("lost {count}"),
        };
        // writing to a string cannot fail
        let _ = writeln!(self.text, "{} {line}", at.nanos());
    }
}

/// Type and checksum of a message.
fn print(sample: &dyn Sample) -> String {
    let encoded = sample.to_datum().and_then(|datum| cbor::encode(&datum));
    match encoded {
        Ok(bytes) => format!("{} {:08x}", sample.type_name(), crc32fast::hash(&bytes)),
        Err(error) => format!("{} {error}", sample.type_name()),
    }
}

fn outcome(result: Result<&dyn Sample, &CallError>) -> String {
    match result {
        Ok(sample) => print(sample),
        Err(error) => error.to_string(),
    }
}

/// A value as JSON: complete, and scalars as the language writes them.
fn written(value: &Datum) -> String {
    json::encode(value).unwrap_or_else(|_| value.to_string())
}

fn report(component: &str, kind: &str, what: &Datum) -> String {
    let mut line = format!("report {component} {kind}");
    if kind == VIOLATION_REPORT
        && let Ok(violation) = what.to::<ViolationRecord>()
    {
        let _ = write!(line, " {violation}");
        return line;
    }
    match what.to::<StepRecord>() {
        Ok(step) if [STEP_REPORT, FAILED_STEP_REPORT].contains(&kind) => {
            let _ = write!(line, " {}", step.number);
            if let Some(rule) = &step.safe_rule {
                let _ = write!(line, "\n  R {rule}");
            }
            for (location, value) in &step.inputs {
                let _ = write!(line, "\n  M {location} = {value}");
            }
            for (index, count) in &step.choices {
                let _ = write!(line, "\n  C {index} of {count}");
            }
            for update in &step.updates {
                let _ = write!(line, "\n  U {} = {}", update.location, update.after);
            }
        }
        _ => {
            let _ = write!(line, " {}", written(what));
        }
    }
    line
}
