//! Connections to message queues, beyond which there is an Orocos component.

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

/// Checks that a port's type has a form in a queue, and that who makes the queue, the writer, knows how large messages are.
pub(super) fn check(
    scene: &CheckedComposite<'_>,
    (way, kind): (PortDirection, Option<&TypeAt>),
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

/// Only a message queue has messages of a fixed size.
pub(super) fn size_elsewhere(connection: &Connection, report: &mut Report) {
    let mut ends = connection.from.iter().chain(&connection.to);
    if let Some(size) = &connection.policy.data_size
        && !ends.any(|end| matches!(end, Terminal::Mqueue(_)))
    {
        let reason = "only messages of a queue `mqueue:/name` have a size";
        let (key, at) = ("data_size", size.span);
        report.found(IdleKey { key, at, reason });
    }
}
