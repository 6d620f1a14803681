//! Reports how a task began to the thread that started it.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use crate::channel::ChannelError;

/// Reports the outcome of a task's first declaration to the thread that started the task, once.
pub(crate) struct FirstDeclaration(Option<SyncSender<Result<(), ChannelError>>>);

impl FirstDeclaration {
    /// Creates the reporting and the receiving end.
    pub(crate) fn new() -> (Self, Receiver<Result<(), ChannelError>>) {
        let (report, outcome) = sync_channel(1);
        (Self(Some(report)), outcome)
    }

    /// Reports the outcome, unless one was reported before. Returns whether the outcome is final: a refusal that
    /// reached the waiting thread is not retried. A queue that cannot be reached is no outcome: the thread goes on waiting.
    pub(crate) fn report(&mut self, end: Result<(), ChannelError>) -> bool {
        if matches!(end, Err(ChannelError::QueueUnreachable { .. })) {
            return false;
        }
        let refused = matches!(end, Err(ChannelError::Closed { .. }));
        match self.0.take() {
            // fails if the thread does not wait; it can read the outcome in the health
            Some(report) => report.send(end).is_ok() && refused,
            None => false,
        }
    }
}
