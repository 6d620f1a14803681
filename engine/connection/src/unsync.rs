//! A cell without synchronisation, for ends that share one thread (RTT UNSYNC).
#![expect(
    unsafe_code,
    reason = "the caller guarantees that all ends are in one thread"
)]

use std::cell::UnsafeCell;
use std::sync::Arc;

/// A shared reference to content that one thread at a time uses.
pub(crate) struct Unsync<T>(Arc<UnsyncCell<T>>);

struct UnsyncCell<T>(UnsafeCell<T>);

// SAFETY: the contract of `Unsync::new` requires that no two threads use the shares at the same time, and that the
// actions of one thread happen before those of the next; `T: Send` allows the content to move between threads.
unsafe impl<T: Send> Sync for UnsyncCell<T> {}

impl<T> Unsync<T> {
    /// Creates the first share.
    ///
    /// # Safety
    /// This share and its clones must be used by one thread. If they move to another thread, they must move together,
    /// and all accesses before the move must happen before those after it.
    pub(crate) unsafe fn new(content: T) -> Self {
        Self(Arc::new(UnsyncCell(UnsafeCell::new(content))))
    }

    /// Calls `f` with the content. `f` must not access this cell again: it moves values in and out, and drops none.
    #[inline]
    pub(crate) fn with<R>(&self, f: impl FnOnce(&mut T) -> R) -> R {
        // SAFETY: no other thread is here, by the contract of `new`. This call is not nested, because all callers are
        // in `shared_buffer` and only move values in and out of a `Store`, which calls no foreign code.
        f(unsafe { &mut *self.0.0.get() })
    }
}

impl<T> Unsync<T> {
    /// Returns the number of shares.
    pub(crate) fn strong_count(&self) -> usize {
        Arc::strong_count(&self.0)
    }
}

impl<T> Clone for Unsync<T> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}
