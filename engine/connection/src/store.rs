//! A bounded queue without synchronisation of its own.

use std::collections::VecDeque;

use crate::buffer_kind::BufferKind;
use crate::push_outcome::PushOutcome;

/// A bounded queue, used by one thread at a time.
pub(crate) struct Store<T> {
    kind: BufferKind,
    queue: VecDeque<T>,
}

impl<T> Store<T> {
    pub(crate) fn new(kind: BufferKind) -> Self {
        Self {
            kind,
            queue: VecDeque::with_capacity(kind.size()),
        }
    }

    /// Appends a value. Returns the displaced value, so that the caller can drop it outside the lock.
    pub(crate) fn push(&mut self, value: T) -> (PushOutcome, Option<T>) {
        if self.queue.len() < self.kind.size() {
            self.queue.push_back(value);
            return (PushOutcome::Stored, None);
        }
        match self.kind {
            BufferKind::Buffer(_) => (PushOutcome::DroppedNewest, Some(value)),
            BufferKind::Circular(_) => {
                let oldest = self.queue.pop_front();
                self.queue.push_back(value);
                (PushOutcome::DroppedOldest, oldest)
            }
            BufferKind::Data => {
                let oldest = self.queue.pop_front();
                self.queue.push_back(value);
                (PushOutcome::Stored, oldest)
            }
        }
    }

    pub(crate) fn pop(&mut self) -> Option<T> {
        self.queue.pop_front()
    }

    pub(crate) fn len(&self) -> usize {
        self.queue.len()
    }
}
