//! A pool: one queue that several writers and readers share. A sample goes to the reader that comes first.

use std::sync::{Arc, Mutex};

use crossbeam_queue::ArrayQueue;

use crate::channel::SharedBuffer;
use crate::store::Store;
use crate::{BufferKind, Receiver, Sender};

/// A queue with as many ends as are asked for.
pub struct Pool<T>(pub(crate) SharedBuffer<T>);

impl<T> Pool<T> {
    /// Kept apart by no lock: nobody ever waits. (The newest sample alone is a circular buffer of one here.)
    pub fn lock_free(kind: BufferKind) -> Self {
        let queue = Arc::new(ArrayQueue::new(kind.size()));
        Self(match kind {
            BufferKind::Data => SharedBuffer::Newest(queue),
            BufferKind::Buffer(_) => SharedBuffer::Buffer(queue),
            BufferKind::Circular(_) => SharedBuffer::Circular(queue),
        })
    }

    /// Kept apart by a lock: whoever comes second waits (RTT LOCKED).
    pub fn locked(kind: BufferKind) -> Self {
        Self(SharedBuffer::Locked(Arc::new(Mutex::new(Store::new(kind)))))
    }

    /// Another writing end.
    pub fn sender(&self) -> Sender<T> {
        Sender::shared(self.0.clone())
    }

    /// Another reading end.
    pub fn receiver(&self) -> Receiver<T> {
        Receiver::shared(self.0.clone())
    }
}

impl<T> Clone for Pool<T> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}
