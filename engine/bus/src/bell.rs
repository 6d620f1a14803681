//! A bell: wakes the one thread that waits for any of several queues.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread::Thread;
use std::time::{Duration, Instant};

/// Rung when something has come. Ringing never waits.
#[derive(Default)]
pub struct Bell {
    rung: AtomicBool,
    waiting: AtomicBool,
    thread: Mutex<Option<Thread>>,
    hammer: Option<Box<dyn Fn() + Send + Sync>>,
}

impl Bell {
    /// A silent bell.
    pub fn new() -> Self {
        Self::default()
    }

    /// A bell that does something when it is rung, for those who cannot wait in a thread. It must not take long.
    pub fn that(hammer: impl Fn() + Send + Sync + 'static) -> Self {
        Self {
            hammer: Some(Box::new(hammer)),
            ..Self::default()
        }
    }

    /// Something has come.
    pub fn ring(&self) {
        if let Some(hammer) = &self.hammer {
            hammer();
        }
        self.rung.store(true, Ordering::SeqCst);
        // The waiter says so before it sleeps, and lets go of the lock at once.
        if self.waiting.swap(false, Ordering::SeqCst)
            && let Some(thread) = &*self.thread.lock().unwrap_or_else(PoisonError::into_inner)
        {
            thread.unpark();
        }
    }

    /// Waits until the bell is rung, or so long. Says whether it was rung since the last wait. For one thread at a
    /// time; another's wait may last its full time.
    pub fn wait(&self, at_most: Duration) -> bool {
        *self.thread.lock().unwrap_or_else(PoisonError::into_inner) = Some(std::thread::current());
        self.waiting.store(true, Ordering::SeqCst);
        if !self.rung.load(Ordering::SeqCst) {
            std::thread::park_timeout(at_most);
        }
        self.waiting.store(false, Ordering::SeqCst);
        self.rung.swap(false, Ordering::SeqCst)
    }
}

impl fmt::Debug for Bell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Bell {{ rung: {:?} }}", self.rung)
    }
}

/// The instant so much later; a year from now, if there is no such instant.
pub fn later(by: Duration) -> Instant {
    let now = Instant::now();
    let year = Duration::from_secs(365 * 24 * 3600);
    now.checked_add(by).unwrap_or_else(|| now + year)
}
