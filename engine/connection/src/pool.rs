//! A pool: one queue that several writers and readers share. A sample goes to the reader that comes first.

use std::sync::{Arc, Mutex};

use crossbeam_queue::ArrayQueue;

use crate::channel::Shared;
use crate::store::Store;
use crate::{Kind, Receiver, Sender};

/// A queue with as many ends as are asked for.
pub struct Pool<T>(pub(crate) Shared<T>);

impl<T> Pool<T> {
    /// Kept apart by no lock: nobody ever waits. (The newest sample alone is a circular buffer of one here.)
    pub fn lock_free(kind: Kind) -> Self {
        let queue = Arc::new(ArrayQueue::new(kind.size()));
        Self(match kind {
            Kind::Data => Shared::Newest(queue),
            Kind::Buffer(_) => Shared::Buffer(queue),
            Kind::Circular(_) => Shared::Circular(queue),
        })
    }

    /// Kept apart by a lock: whoever comes second waits (RTT LOCKED).
    pub fn locked(kind: Kind) -> Self {
        Self(Shared::Locked(Arc::new(Mutex::new(Store::new(kind)))))
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
