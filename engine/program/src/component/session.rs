//! A started program that has been configured, with the thread that watches it.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use asmotion_bus::Standstills;
use asmotion_component::Setup;
use asmotion_datum::Datum;

use crate::connection::ProgramConnection;
use crate::declaration::{ProgramClock, ProgramDeclaration, connect};
use crate::error::ProgramError;
use crate::process::ProgramCommand;
use crate::request::ProgramRequest;
use crate::watcher::{ProgramWatcher, SharedConnection, lock};

/// A started program. Dropping it ends the program.
pub(super) struct ProgramSession {
    connection: SharedConnection,
    /// Waits for `wake`; `None` in simulated time.
    watcher: Option<ProgramWatcher>,
    timeout: Duration,
}

impl ProgramSession {
    /// Starts a program and compares its declaration.
    pub(super) fn start(
        command: &ProgramCommand,
        expected: &ProgramDeclaration,
        setup: &Setup<'_>,
    ) -> Result<Self, ProgramError> {
        let waker = setup.waker();
        let clock = if waker.is_some() {
            ProgramClock::Wall
        } else {
            ProgramClock::Virtual
        };
        let (connection, declaration) = connect(command, setup.name(), clock)?;
        if !declaration.is_declared_alike(expected) {
            return Err(ProgramError::protocol(
                "the program declares other ports, services, references or properties than when the composite was checked",
            ));
        }
        let connection = Arc::new(Mutex::new(connection));
        Ok(Self {
            watcher: waker.map(|waker| ProgramWatcher::start(&connection, waker)),
            connection,
            timeout: command.timeout,
        })
    }

    /// Sends a request and waits for the reply.
    pub(super) fn exchange(
        &self,
        request: ProgramRequest,
        kind: &'static str,
    ) -> Result<Datum, ProgramError> {
        let mut connection = lock(&self.connection);
        let watched = |is_watched| {
            if let Some(watcher) = &self.watcher {
                watcher.set_watched(is_watched);
            }
        };
        watched(false);
        let reply = connection.exchange(&request.datum(), kind, self.timeout);
        watched(true);
        reply
    }

    pub(super) fn is_closed(&self) -> bool {
        lock(&self.connection).is_closed()
    }

    /// Removes and returns up to `limit` lines that the program has printed, and the number of lines left out.
    pub(super) fn take_lines(&self, limit: usize) -> (Vec<String>, u64) {
        lock(&self.connection).log.take(limit)
    }

    /// Sends the request of a cycle and waits for the reply. Returns also for how long, at most, what the reply contains has waited
    /// because this process stood still: since the program sent a `wake`, or on the way. Zero in simulated time.
    pub(super) fn cycle(
        &self,
        request: ProgramRequest,
        kind: &'static str,
    ) -> (Result<Datum, ProgramError>, Duration) {
        let began = Instant::now();
        let asked = lock(&self.connection).take_first_wake();
        let reply = self.exchange(request, kind);
        let mut connection = lock(&self.connection);
        let asked_meanwhile = connection.take_first_wake();
        if asked_meanwhile.is_some() {
            // what the next cycle passes on was made after this one was requested
            connection.note_wake(began);
        }
        drop(connection);
        let asked = asked.into_iter().chain(asked_meanwhile);
        let since = asked.fold(began, Instant::min);
        let waited = |_| Standstills::of_process().waited(since);
        (reply, self.watcher.as_ref().map_or(Duration::ZERO, waited))
    }

    /// Returns whether the program has requested a cycle during the last exchange.
    pub(super) fn take_wake(&self) -> bool {
        // in simulated time nothing outside of the system triggers a cycle
        self.watcher.is_some() && lock(&self.connection).take_wake()
    }
}

impl Drop for ProgramSession {
    fn drop(&mut self) {
        ProgramConnection::end(&mut lock(&self.connection));
        if let Some(watcher) = &mut self.watcher {
            watcher.end();
        }
    }
}
