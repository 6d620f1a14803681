//! Pools without synchronisation, for ends that share one thread (RTT UNSYNC).
#![expect(
    unsafe_code,
    reason = "the caller guarantees that all ends are in one thread"
)]

use super::Pool;
use crate::buffer_kind::BufferKind;
use crate::shared_buffer::SharedBuffer;
use crate::store::Store;
use crate::unsync::Unsync;

impl<T> Pool<T> {
    /// Creates a pool without synchronisation (RTT UNSYNC).
    ///
    /// # Safety
    /// The pool and its ends must be used by one thread. If they move to another thread, they must move together, and
    /// all accesses before the move must happen before those after it.
    pub unsafe fn unsync(kind: BufferKind) -> Self {
        // SAFETY: upheld by the caller
        Self(SharedBuffer::Unsync(unsafe {
            Unsync::new(Store::new(kind))
        }))
    }
}

#[cfg(all(test, not(feature = "loom")))]
pub(crate) mod tests {
    use super::*;

    /// Creates a pool for tests, each of which runs in one thread.
    pub(crate) fn in_this_thread<T>(kind: BufferKind) -> Pool<T> {
        // SAFETY: the test keeps the pool and its ends in its thread
        unsafe { Pool::unsync(kind) }
    }
}
