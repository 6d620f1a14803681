//! Events as lines of text, for logs and for comparing two runs.

use std::fmt;

use asmotion_component::{CallError, Fault};
use asmotion_datum::Sample;

use super::Event;

/// Writes one line without a time; equal runs give equal lines.
impl fmt::Display for Event<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cycle { component, number } => write!(f, "{component}: cycle {number}"),
            Self::Published {
                component,
                port,
                topic,
                sequence,
                sample,
            } => {
                write!(f, "{component}.{port} #{sequence}")?;
                if let Some(topic) = topic {
                    write!(f, " on {topic}")?;
                }
                write!(f, " = {}", SampleText(*sample))
            }
            Self::Injected {
                target: place,
                sample,
                ..
            } => write!(f, "{place} <- {}", SampleText(*sample)),
            Self::Called {
                component,
                reference,
                operation,
                call,
                attempt,
                argument,
            } => write!(
                f,
                "{component}.{reference}.{operation} call {} attempt {attempt}: {}",
                call.0,
                SampleText(*argument)
            ),
            Self::Answered {
                component,
                service,
                operation,
                caller,
                result,
            } => write!(
                f,
                "{component}.{service}.{operation} answers {caller}: {}",
                CallEndText(result)
            ),
            Self::Replied {
                component,
                reference,
                operation,
                call,
                result,
            } => write!(
                f,
                "{component}.{reference}.{operation} call {} ends: {}",
                call.0,
                CallEndText(result)
            ),
            Self::LifeCycle {
                component,
                from,
                to,
            } => write!(f, "{component}: {from} -> {to}"),
            Self::Fault { component, fault } => write!(f, "{component}: fault: {fault}"),
            Self::Overrun { component, missed } => {
                let fault = Fault::Overrun { missed: *missed };
                write!(f, "{component}: {fault}")
            }
            Self::Late {
                component,
                took,
                deadline,
            } => write!(
                f,
                "{component}: a cycle took {took:?}, and has {deadline:?}"
            ),
            Self::Denied { component, denied } => write!(f, "{component}: {denied}"),
            Self::Dropped {
                component,
                port,
                to,
                total,
                reason,
            } => {
                write!(f, "{component}.{port} -> {to}: {total} dropped")?;
                match reason {
                    Some(reason) => write!(f, ": {reason}"),
                    None => Ok(()),
                }
            }
            Self::Property {
                component,
                property,
                value,
            } => write!(f, "{component}.{property} := {value}"),
            Self::Report {
                component,
                kind,
                data: what,
            } => write!(f, "{component}: {kind}: {what}"),
            Self::Lost { count } => write!(f, "{count} events lost"),
        }
    }
}

/// A sample as text; the reason if it cannot be represented as a datum.
struct SampleText<'a>(&'a dyn Sample);

impl fmt::Display for SampleText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.to_datum() {
            Ok(datum) => write!(f, "{datum}"),
            Err(error) => write!(f, "({error})"),
        }
    }
}

/// The result of a call as text.
struct CallEndText<'a>(&'a Result<&'a dyn Sample, &'a CallError>);

impl fmt::Display for CallEndText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Ok(response) => write!(f, "{}", SampleText(*response)),
            Err(error) => write!(f, "{error}"),
        }
    }
}
