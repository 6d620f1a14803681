//! A cell without synchronisation, for ends that share one thread (RTT UNSYNC).
#![allow(
    unsafe_code,
    reason = "the promise of one thread is the caller's, and argued where it is made"
)]

use std::cell::UnsafeCell;
use std::sync::Arc;

use crate::buffer_kind::BufferKind;
use crate::channel::SharedBuffer as Kept;
use crate::pool::Pool;
use crate::store::Store;

/// A share of something that one thread at a time uses.
pub(crate) struct Unsync<T>(Arc<UnsyncCell<T>>);

struct UnsyncCell<T>(UnsafeCell<T>);

// SAFETY: `Unsync::new` has its caller promise that no two threads use the shares at one time, and that what one thread
// did happened before what the next one does; `T: Send` lets the content change threads with them.
unsafe impl<T: Send> Sync for UnsyncCell<T> {}

impl<T> Unsync<T> {
    /// Creates the first share.
    ///
    /// # Safety
    /// This share and its clones are used by one thread; or, if they change to another one, all of them together, what
    /// was done before happening before what is done after.
    pub(crate) unsafe fn new(content: T) -> Self {
        Self(Arc::new(UnsyncCell(UnsafeCell::new(content))))
    }

    /// Calls `act` with the content. `act` must not reach this cell again: it moves values in and out, and drops
    /// none.
    #[inline]
    pub(crate) fn with<R>(&self, act: impl FnOnce(&mut T) -> R) -> R {
        // SAFETY: no other thread is here, by the promise given to `new`; and this call is not nested, since all
        // callers are in `channel` and only move values in and out of a `Store`, which calls no foreign code.
        act(unsafe { &mut *self.0.0.get() })
    }
}

impl<T> Unsync<T> {
    /// Returns the number of shares.
    pub(crate) fn shares(&self) -> usize {
        Arc::strong_count(&self.0)
    }
}

impl<T> Clone for Unsync<T> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<T> Pool<T> {
    /// Not kept apart (RTT UNSYNC).
    ///
    /// # Safety
    /// The pool and its ends are used by one thread; or, if they change to another one, all of them together, what was
    /// done before happening before what is done after.
    pub unsafe fn unsync(kind: BufferKind) -> Self {
        // SAFETY: as the caller promises.
        Self(Kept::Unsync(unsafe { Unsync::new(Store::new(kind)) }))
    }
}

#[cfg(all(test, not(feature = "loom")))]
pub(crate) mod tests {
    use super::*;

    /// For tests, which run each in one thread.
    pub(crate) fn in_this_thread<T>(kind: BufferKind) -> Pool<T> {
        // SAFETY: the test keeps the pool and its ends in its thread.
        unsafe { Pool::unsync(kind) }
    }
}
