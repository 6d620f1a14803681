//! The open connections: limits their number, and makes room by closing the one that has been idle for the longest time.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use tokio::sync::oneshot;

/// The open connections of a gateway.
#[derive(Clone)]
pub(crate) struct OpenConnections {
    limit: usize,
    state: Arc<Mutex<OpenConnectionsState>>,
}

#[derive(Default)]
struct OpenConnectionsState {
    next_number: u64,
    connections: BTreeMap<u64, ConnectionActivity>,
}

/// Activity of a connection.
struct ConnectionActivity {
    /// Begin of the wait for a complete request; `None` while a call is under way.
    idle_since: Option<Instant>,
    /// Dropped with this entry, which closes the connection.
    _close: oneshot::Sender<()>,
}

/// The place of a connection in the table, given back when dropped.
pub struct ConnectionPlace {
    table: OpenConnections,
    number: u64,
}

/// Marks a connection as having a call under way, until it is dropped.
pub struct CallGuard<'p>(&'p ConnectionPlace);

impl OpenConnections {
    /// Creates a table for this number of connections, at least one.
    pub(crate) fn new(limit: usize) -> Self {
        Self {
            limit: limit.max(1),
            state: Arc::default(),
        }
    }

    fn state(&self) -> MutexGuard<'_, OpenConnectionsState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Enters a new connection, if necessary in place of the one that has been idle for the longest time. The receiver ends when
    /// the new connection has to be closed in turn. Returns `None` if calls are under way on all connections.
    pub(crate) fn enter(&self) -> Option<(ConnectionPlace, oneshot::Receiver<()>)> {
        let mut state = self.state();
        if state.connections.len() >= self.limit {
            let idle = state.connections.iter();
            let idle = idle.filter_map(|(number, it)| Some((it.idle_since?, *number)));
            let (_, longest) = idle.min()?;
            state.connections.remove(&longest);
        }
        let number = state.next_number;
        state.next_number += 1;
        let (close, closed) = oneshot::channel();
        let activity = ConnectionActivity {
            idle_since: Some(Instant::now()),
            _close: close,
        };
        state.connections.insert(number, activity);
        drop(state);
        let place = ConnectionPlace {
            table: self.clone(),
            number,
        };
        Some((place, closed))
    }
}

impl ConnectionPlace {
    /// Marks the connection as having a call under way.
    pub fn begin_call(&self) -> CallGuard<'_> {
        self.set_idle_since(None);
        CallGuard(self)
    }

    fn set_idle_since(&self, idle_since: Option<Instant>) {
        if let Some(activity) = self.table.state().connections.get_mut(&self.number) {
            activity.idle_since = idle_since;
        }
    }
}

impl Drop for ConnectionPlace {
    fn drop(&mut self) {
        self.table.state().connections.remove(&self.number);
    }
}

impl Drop for CallGuard<'_> {
    fn drop(&mut self) {
        self.0.set_idle_since(Some(Instant::now()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_connection_that_has_been_idle_for_the_longest_time_makes_room() {
        let table = OpenConnections::new(2);
        let (first, mut first_closed) = table.enter().unwrap();
        let (_second, mut second_closed) = table.enter().unwrap();
        // a call makes a connection busy, and then the one that was idle last
        drop(first.begin_call());
        let (third, _third_closed) = table.enter().unwrap();
        assert!(
            second_closed
                .try_recv()
                .is_err_and(|it| it == oneshot::error::TryRecvError::Closed)
        );
        assert!(
            first_closed
                .try_recv()
                .is_err_and(|it| it == oneshot::error::TryRecvError::Empty)
        );
        let _calls = (first.begin_call(), third.begin_call());
        assert!(table.enter().is_none());
    }
}
