//! The thread that waits for `wake` messages, and for the end of a program between two cycles.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use crate::connection::ProgramConnection;
use crate::waiting::wait_readable;

/// Longest wait before the thread looks whether it is to end. Usually it is woken by the end of the connection.
const NAP: Duration = Duration::from_millis(500);

/// Shortest time between two cycles that a program requests by `wake`.
const PAUSE: Duration = Duration::from_millis(1);

/// Number of chunks of the log that are read at a time. A program that prints endlessly waits for the pipe.
const CHUNKS: usize = 1;

/// Requests a cycle of the component.
pub(crate) type CycleWaker = Arc<dyn Fn() + Send + Sync>;

/// A connection that the component's thread and its watcher share. The component locks it for an exchange.
pub(crate) type SharedConnection = Arc<Mutex<ProgramConnection>>;

/// Locks a connection; it is consistent even if a thread panicked while it held the lock.
pub(crate) fn lock(connection: &Mutex<ProgramConnection>) -> MutexGuard<'_, ProgramConnection> {
    connection.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The thread that watches a connection.
pub(crate) struct ProgramWatcher {
    is_to_end: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl ProgramWatcher {
    /// Starts to watch. Without a thread, `wake` takes effect at the next exchange only.
    pub(crate) fn start(connection: &SharedConnection, waker: CycleWaker) -> Self {
        let is_to_end = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&is_to_end);
        let stream = lock(connection).stream().try_clone();
        let connection = Arc::clone(connection);
        let builder = std::thread::Builder::new().name("program".to_owned());
        let thread = stream.and_then(|stream| {
            builder.spawn(move || {
                while !flag.load(Ordering::Acquire) {
                    wait_readable(&stream, NAP);
                    // waits for the end of an exchange
                    let mut connection = lock(&connection);
                    let has_ended = connection.receive_unasked();
                    connection.log.read(CHUNKS);
                    let has_woken = connection.take_wake();
                    drop(connection);
                    if has_woken || has_ended {
                        waker();
                    }
                    if has_ended {
                        return;
                    }
                    if has_woken {
                        std::thread::sleep(PAUSE);
                    }
                }
            })
        });
        Self {
            is_to_end,
            thread: thread.ok(),
        }
    }

    /// Ends the thread; the connection must have been closed.
    pub(crate) fn end(&mut self) {
        self.is_to_end.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            // a panic there has been reported by its hook
            let _ = thread.join();
        }
    }
}
