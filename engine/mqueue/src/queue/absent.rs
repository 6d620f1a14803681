//! Replacement for operating systems without message queues.

use std::time::Duration;

use crate::capacity::QueueCapacity;
use crate::error::QueueCheckError;
use crate::name::QueueName;
use crate::queue_priority::QueuePriority;

/// A queue that cannot be opened, and therefore has no values.
pub(crate) enum KernelQueue {}

/// The outcome of sending a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SendOutcome {
    Stored,
    Full,
}

/// The process that created a queue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum QueueOrigin {
    Created,
    #[allow(dead_code, reason = "no queue can be found")]
    Found,
}

/// Another descriptor of a queue; there is none.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum QueueHolder {}

/// The descriptors that a search takes into account.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum HolderAccess {
    Any,
    Writing,
}

/// The outcome of a search.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct HolderSearch {
    pub found: Vec<QueueHolder>,
    pub complete: bool,
}

impl KernelQueue {
    pub(crate) fn create(
        name: &QueueName,
        _: QueueCapacity,
    ) -> Result<(Self, QueueOrigin), QueueCheckError> {
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

    pub(crate) fn count(&self) -> usize {
        match *self {}
    }

    pub(crate) fn push(&self, _: &[u8], _: QueuePriority) -> Result<SendOutcome, QueueCheckError> {
        match *self {}
    }

    pub(crate) fn pop(
        &self,
        _: &mut [u8],
    ) -> Result<Option<(usize, QueuePriority)>, QueueCheckError> {
        match *self {}
    }

    pub(crate) fn find_holders(&self, _: HolderAccess) -> HolderSearch {
        match *self {}
    }

    pub(crate) fn is_held_by(&self, _: &QueueHolder) -> bool {
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
