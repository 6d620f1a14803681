//! A pool is one queue shared by several writers and readers. Each sample goes to the first reader that takes it.

use std::sync::{Arc, Mutex};

use crossbeam_queue::ArrayQueue;

use crate::buffer_kind::BufferKind;
use crate::channel::{Receiver, Sender, SharedBuffer};
use crate::store::Store;

/// A queue with any number of writing and reading ends.
pub struct Pool<T>(pub(crate) SharedBuffer<T>);

impl<T> Pool<T> {
    /// Creates a lock-free pool. (A data pool is a circular buffer of one sample.)
    pub fn lock_free(kind: BufferKind) -> Self {
        let queue = Arc::new(ArrayQueue::new(kind.size()));
        Self(match kind {
            BufferKind::Data => SharedBuffer::Newest(queue),
            BufferKind::Buffer(_) => SharedBuffer::Buffer(queue),
            BufferKind::Circular(_) => SharedBuffer::Circular(queue),
        })
    }

    /// Creates a pool guarded by a lock, so that ends may wait for each other (RTT LOCKED).
    pub fn locked(kind: BufferKind) -> Self {
        Self(SharedBuffer::Locked(Arc::new(Mutex::new(Store::new(kind)))))
    }

    /// Creates another writing end.
    pub fn sender(&self) -> Sender<T> {
        Sender::shared(self.0.clone())
    }

    /// Creates another reading end.
    pub fn receiver(&self) -> Receiver<T> {
        Receiver::shared(self.0.clone())
    }
}

impl<T> Clone for Pool<T> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}
