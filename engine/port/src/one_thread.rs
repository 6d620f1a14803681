//! Connections without any guard, for components that share a thread.
#![allow(unsafe_code, reason = "the promise of one thread; argued below")]

use asmotion_connection::{BufferKind, Pool};

/// A queue whose ends are all in one thread.
pub(crate) fn pool<T>(kind: BufferKind) -> Pool<T> {
    // SAFETY: the ends lie in the ports of components, and nowhere else: injection ports, and writers and readers outside
    // of the system, have connections with a lock or lock-free ones (`Policy::for_outsider`). The runtime's
    // `ConnectionTable::admit` lets an unsynchronised connection be made only between components that are in one thread,
    // each being the other's master or slave. These components change threads together, if at all: they are built in the
    // `System`, handed over as a whole to the `Simulation`, which one thread at a time has, or to one `Worker` before its
    // thread begins. To ends that are made while it runs the same applies from where they are put into the components,
    // by messages to that one thread; until then nobody uses them.
    unsafe { Pool::unsync(kind) }
}
