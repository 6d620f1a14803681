//! Connections to message queues, beyond which there is an Orocos component.

use asmotion_diagnostics::{Diagnostic, Report, Span};
use asmotion_mqueue::{Layout, LayoutError};

use super::connection_error::ConnectionError;
use super::face::{Kind, Way};
use super::scene::Scene;
use crate::At;
use crate::finding::{Finding, Findings};
use crate::model::{Connection, Terminal};

#[derive(Debug, thiserror::Error)]
pub(super) enum QueueError {
    #[error("`{kind}` cannot pass through `mqueue:{queue}`: {reason}")]
    NoForm {
        kind: String,
        queue: String,
        reason: LayoutError,
        at: Span,
    },
    #[error("how large are the messages of `mqueue:{queue}`?")]
    NoSize {
        kind: String,
        queue: String,
        at: Span,
    },
}

impl Finding for QueueError {
    fn diagnostic(&self) -> Diagnostic {
        match self {
            Self::NoForm { at, .. } => Diagnostic::error("C061", self)
                .label(*at, "Orocos writes no such type")
                .help(
                    "numbers, truth values, arrays, lists and records of them have one: put a \
                     component between that leaves the rest out",
                ),
            Self::NoSize { kind, at, .. } => Diagnostic::error("C062", self)
                .label(
                    *at,
                    format!("`{kind}` has lists, which may be of any length"),
                )
                .help(format!(
                    "say how many bytes the largest has, the same as on the other side: \
                     `policy = {{ data_size = {EXAMPLE} }}`"
                )),
        }
    }
}

/// Bytes of a message, in an example.
const EXAMPLE: usize = 256;

/// Checks that a port's type has a form in a queue, and that who makes the queue, the writer, knows how large messages are.
pub(super) fn check(
    scene: &Scene<'_>,
    (way, kind): (Way, Option<&Kind>),
    connection: &Connection,
    queue: &At<String>,
    report: &mut Report,
) {
    // what nobody knows is told when it is put together
    let Some((kind, schema)) = kind.and_then(|kind| Some((kind, scene.types.schema(&kind.text)?)))
    else {
        return;
    };
    let kind = kind.text.clone();
    let (queue, at) = (queue.value.clone(), queue.span);
    match Layout::of(&schema) {
        Err(reason) => report.found(QueueError::NoForm {
            kind,
            queue,
            reason,
            at,
        }),
        Ok(layout)
            if way == Way::Out
                && layout.size().is_none()
                && connection.policy.data_size.is_none() =>
        {
            report.found(QueueError::NoSize { kind, queue, at });
        }
        Ok(_) => {}
    }
}

/// Only a message queue has messages of a fixed size.
pub(super) fn size_elsewhere(connection: &Connection, report: &mut Report) {
    let mut ends = connection.from.iter().chain(&connection.to);
    if let Some(size) = &connection.policy.data_size
        && !ends.any(|end| matches!(end, Terminal::Mqueue(_)))
    {
        let reason = "only messages of a queue `mqueue:/name` have a size";
        let (key, at) = ("data_size", size.span);
        report.found(ConnectionError::Idle { key, at, reason });
    }
}
