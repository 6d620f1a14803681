//! Word of how a task began, for the thread that began it.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use crate::channel::ChannelError;

/// Tells once how the first declaration ended.
pub(crate) struct FirstDeclaration(Option<SyncSender<Result<(), ChannelError>>>);

impl FirstDeclaration {
    /// The telling end and the hearing one.
    pub(crate) fn new() -> (Self, Receiver<Result<(), ChannelError>>) {
        let (tell, told) = sync_channel(1);
        (Self(Some(tell)), told)
    }

    /// Tells, if it has not yet. Says whether the end is final: who is refused at once, and hears it, does not try again.
    pub(crate) fn tell(&mut self, end: Result<(), ChannelError>) -> bool {
        let refused = matches!(end, Err(ChannelError::Closed { .. }));
        match self.0.take() {
            // Who does not wait for it sees it in the health.
            Some(tell) => tell.send(end).is_ok() && refused,
            None => false,
        }
    }
}
