//! The thread that waits for `wake` messages, and for the end of a program between two cycles.

use std::io;
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use asmotion_bus::Standstills;
use rustix::event::epoll;

use crate::connection::ProgramConnection;
use crate::waiting::timespec;

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
    /// `None` without a thread.
    readiness: Option<Arc<Readiness>>,
    thread: Option<JoinHandle<()>>,
}

/// Wakes the watcher when the socket becomes readable, except during an exchange: the component's thread waits for the reply, and
/// would have to share the processor with a thread that is woken to find nothing.
struct Readiness {
    events: OwnedFd,
    stream: UnixStream,
}

impl Readiness {
    fn new(stream: UnixStream) -> io::Result<Self> {
        let events = epoll::create(epoll::CreateFlags::CLOEXEC)?;
        let data = epoll::EventData::new_u64(0);
        epoll::add(&events, &stream, data, epoll::EventFlags::IN)?;
        Ok(Self { events, stream })
    }

    fn set_watched(&self, is_watched: bool) {
        let flags = if is_watched {
            epoll::EventFlags::IN
        } else {
            epoll::EventFlags::empty()
        };
        let data = epoll::EventData::new_u64(0);
        // cannot fail: the socket is registered. If it could, the watcher would wake for nothing or too late
        let _ = epoll::modify(&self.events, &self.stream, data, flags);
    }

    /// Waits until the socket is readable, or for this time.
    fn wait(&self, limit: Duration) {
        let mut events = [epoll::Event {
            flags: epoll::EventFlags::empty(),
            data: epoll::EventData::new_u64(0),
        }];
        // an interrupted wait is a short one
        let _ = epoll::wait(&self.events, &mut events[..], Some(&timespec(limit)));
    }
}

impl ProgramWatcher {
    /// Starts to watch. Without a thread, `wake` takes effect at the next exchange only.
    pub(crate) fn start(connection: &SharedConnection, waker: CycleWaker) -> Self {
        let is_to_end = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&is_to_end);
        let stream = lock(connection).stream().try_clone();
        let readiness = stream.and_then(Readiness::new).ok().map(Arc::new);
        let thread = readiness.clone().and_then(|readiness| {
            let connection = Arc::clone(connection);
            // looks at the clock from now on
            Standstills::of_process();
            let builder = std::thread::Builder::new().name("program".to_owned());
            let run = move || {
                while !flag.load(Ordering::Acquire) {
                    readiness.wait(NAP);
                    if !watch(&connection, &waker) {
                        return;
                    }
                }
            };
            builder.spawn(run).ok()
        });
        Self {
            is_to_end,
            readiness,
            thread,
        }
    }

    /// Lets data of the program wake the thread, or not during an exchange. The caller has locked the connection.
    pub(crate) fn set_watched(&self, is_watched: bool) {
        if let Some(readiness) = &self.readiness {
            readiness.set_watched(is_watched);
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

/// Receives what a program has sent outside of an exchange. Returns `false` if the program has ended.
fn watch(connection: &SharedConnection, waker: &CycleWaker) -> bool {
    // waits for the end of an exchange
    let mut connection = lock(connection);
    let has_ended = connection.receive_unasked();
    connection.log.read(CHUNKS);
    let has_woken = connection.take_wake();
    drop(connection);
    if has_woken || has_ended {
        waker();
    }
    if has_woken && !has_ended {
        std::thread::sleep(PAUSE);
    }
    !has_ended
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]

    use std::io::Write;
    use std::time::Instant;

    use super::*;

    #[test]
    fn a_reply_wakes_no_watcher_and_what_follows_it_does() {
        let (mut program, engine) = UnixStream::pair().unwrap();
        let readiness = Readiness::new(engine).unwrap();
        readiness.set_watched(false);
        program.write_all(b"reply").unwrap();
        let begin = Instant::now();
        readiness.wait(Duration::from_millis(50));
        assert!(begin.elapsed() >= Duration::from_millis(50));
        // as long as it is not read
        readiness.set_watched(true);
        readiness.wait(Duration::from_secs(600));
        assert!(begin.elapsed() < Duration::from_secs(60));
    }
}
