//! A pool is one queue shared by several writers and readers. Each sample goes to the first reader that takes it.

pub(crate) mod unsync;

use std::sync::{Arc, Mutex};

use crate::buffer_kind::BufferKind;
use crate::channel::{Receiver, Sender};
use crate::shared_buffer::SharedBuffer;
use crate::store::Store;

/// A queue with any number of writing and reading ends.
pub struct Pool<T>(pub(crate) SharedBuffer<T>);

impl<T> Pool<T> {
    /// Creates a lock-free pool. (A data pool is a circular buffer of one sample.)
    pub fn lock_free(kind: BufferKind) -> Self {
        Self(SharedBuffer::lock_free(kind))
    }

    /// Creates a lock-free pool whose memory is allocated with the first sample, by the thread that sends it.
    pub fn on_demand(kind: BufferKind) -> Self {
        Self(SharedBuffer::on_demand(kind))
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
