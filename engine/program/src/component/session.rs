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
        let began = Instant::now();
        let mut connection = lock(&self.connection);
        let watched = |is_watched| {
            if let Some(watcher) = &self.watcher {
                watcher.set_watched(is_watched);
            }
        };
        watched(false);
        let reply = connection.exchange(&request.datum(), kind, self.timeout);
        watched(true);
        if let Some(watcher) = self.watcher.as_ref().filter(|_| connection.has_woken()) {
            watcher.note_wake(began);
        }
        reply
    }

    pub(super) fn is_closed(&self) -> bool {
        lock(&self.connection).is_closed()
    }

    /// Removes and returns up to `limit` lines that the program has printed, and the number of lines left out.
    pub(super) fn take_lines(&self, limit: usize) -> (Vec<String>, u64) {
        lock(&self.connection).log.take(limit)
    }

    /// Returns a time since when the program may have waited for the present cycle: before its earliest `wake`, or now.
    pub(super) fn take_first_wake(&self) -> Instant {
        let watcher = self.watcher.as_ref();
        let first = watcher.and_then(ProgramWatcher::take_first_wake);
        first.unwrap_or_else(Instant::now)
    }

    /// Returns for how long, at most, what the program has made since a time has waited because this process stood still. Zero in
    /// simulated time.
    pub(super) fn waited(&self, since: Instant) -> Duration {
        let watcher = self.watcher.as_ref();
        watcher.map_or(Duration::ZERO, |_| Standstills::of_process().waited(since))
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
