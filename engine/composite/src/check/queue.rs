//! Checks connections to POSIX message queues, which exchange data with Orocos components.

use crate::codes::c048::IdleKey;
use crate::codes::c061::NoMqueueLayout;
use crate::codes::c062::NoMqueueSize;
use asmotion_diagnostics::Report;
use asmotion_mqueue::QueueLayout;

use super::endpoints::{PortDirection, TypeAt};
use super::scene::CheckedComposite;
use crate::at::At;
use crate::finding::Findings;
use crate::model::{Connection, Terminal};

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

/// Reports policy keys that have no effect: `data_size` without a message queue, and `init` with one.
pub(super) fn idle_keys(connection: &Connection, report: &mut Report) {
    let mut ends = connection.from.iter().chain(&connection.to);
    let has_queue = ends.any(|end| matches!(end, Terminal::Mqueue(_)));
    if let Some(size) = &connection.policy.data_size
        && !has_queue
    {
        let reason = "only messages of a queue `mqueue:/name` have a size";
        let (key, at) = ("data_size", size.span);
        report.found(IdleKey { key, at, reason });
    }
    if let Some(init) = &connection.policy.init
        && init.value
        && has_queue
    {
        let reason = "messages of a queue are not repeated for new readers";
        let (key, at) = ("init", init.span);
        report.found(IdleKey { key, at, reason });
    }
}
