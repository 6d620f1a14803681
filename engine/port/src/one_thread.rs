//! Connections without synchronisation, for components in the same thread.
#![expect(
    unsafe_code,
    reason = "the guarantee that all ends are in one thread; argued below"
)]

use asmotion_connection::{BufferKind, Pool};

/// A queue whose ends are all in one thread.
pub(crate) fn pool<T>(kind: BufferKind) -> Pool<T> {
    // SAFETY: all ends of the queue are used by one thread.
    //
    // The ends are stored in the ports of components, and nowhere else: injection ports, and writers and readers
    // outside the system, use connections with a lock or lock-free ones (`Policy::for_outsider`). The runtime's
    // `ConnectionTable::admit` accepts an unsynchronised connection only between components in the same thread, where
    // one is, directly or indirectly, the other's slave.
    //
    // These components change threads only together: they are built in the `System` and moved as a whole into the
    // `Simulation`, which is used by one thread at a time, or into one `ComponentGroup`. A thread owns the group while it
    // uses it: its own thread from its start to its end, or an executor thread for a turn. Between turns the group is behind
    // the lock of the `SeatSchedule`, so that what a thread did in a turn happens before the next turn. Ends created during a
    // run are sent to the group in messages and put into the components there; nothing uses them before.
    unsafe { Pool::unsync(kind) }
}
