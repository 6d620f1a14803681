//! Checks connections to POSIX message queues, which exchange data with Orocos components.

use crate::codes::c061::NoMqueueLayout;
use crate::codes::c062::NoMqueueSize;
use asmotion_diagnostics::Report;
use asmotion_mqueue::QueueLayout;

use super::endpoints::{PortDirection, TypeAt};
use super::scene::CheckedComposite;
use crate::at::At;
use crate::finding::Findings;
use crate::model::Connection;

/// Checks that the message type of the port has a queue layout, and that the size of its messages is known if the port
/// is the writer, which creates the queue.
pub(super) fn check(
    scene: &CheckedComposite<'_>,
    (way, kind): (PortDirection, Option<&TypeAt>),
    connection: &Connection,
    queue: &At<String>,
    report: &mut Report,
) {
    // unknown types are checked when the system starts
    let Some((kind, schema)) = kind.and_then(|kind| Some((kind, scene.types.schema(&kind.text)?)))
    else {
        return;
    };
    let kind = kind.text.clone();
    let (queue, at) = (queue.value.clone(), queue.span);
    match QueueLayout::of(&schema) {
        Err(reason) => report.found(NoMqueueLayout {
            kind,
            queue,
            reason,
            at,
        }),
        Ok(layout)
            if way == PortDirection::Out
                && layout.size().is_none()
                && connection.policy.data_size.is_none() =>
        {
            report.found(NoMqueueSize { kind, queue, at });
        }
        Ok(_) => {}
    }
}
