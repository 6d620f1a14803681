//! Replacement for operating systems without message queues.

use std::time::Duration;

use crate::capacity::QueueCapacity;
use crate::error::QueueCheckError;
use crate::name::QueueName;

/// A queue that cannot be opened, and therefore has no values.
pub(crate) enum KernelQueue {}

/// The outcome of sending a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SendOutcome {
    Stored,
    Full,
}

impl KernelQueue {
    pub(crate) fn create(name: &QueueName, _: QueueCapacity) -> Result<Self, QueueCheckError> {
        Err(QueueCheckError::Unsupported {
            queue: name.to_string(),
        })
    }

    pub(crate) fn open_existing(name: &QueueName) -> Result<Option<Self>, QueueCheckError> {
        Err(QueueCheckError::Unsupported {
            queue: name.to_string(),
        })
    }

    pub(crate) fn size(&self) -> usize {
        match *self {}
    }

    pub(crate) fn push(&self, _: &[u8]) -> Result<SendOutcome, QueueCheckError> {
        match *self {}
    }

    pub(crate) fn pop(&self, _: &mut [u8]) -> Result<Option<usize>, QueueCheckError> {
        match *self {}
    }

    pub(crate) fn wait(&self, _: Duration) {
        match *self {}
    }

    pub(crate) fn is_unlinked(&self) -> bool {
        match *self {}
    }

    pub(crate) fn unlink(&self) {
        match *self {}
    }
}
