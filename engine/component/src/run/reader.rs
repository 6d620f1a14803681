//! Readers: those outside of a system who read one of its ports, by a connection of their own.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use asmotion_bus::Bell;
use asmotion_datum::Message;

use super::Beyond;
use crate::Flow;
use crate::port::{AnyInput, Input};

/// The longest sleep, should a bell go unheard.
const NAP: Duration = Duration::from_millis(100);

/// Reads an output port from outside of the system; see [`Run::reader`](crate::Run::reader). Every look is a cycle of
/// its own: what was new at the last one is old.
pub struct Reader<T: Message> {
    pub(super) port: String,
    pub(super) input: Input<T>,
    /// Rung for every sample; the writer has the connection as long as it is there.
    pub(super) bell: Arc<Bell>,
    pub(super) dropped: Arc<AtomicU64>,
    pub(super) beyond: Arc<dyn Beyond>,
}

/// Tells an observer what comes, in a thread of its own that ends with this.
#[must_use = "it ends when it is dropped"]
pub struct Subscription {
    ended: Arc<AtomicBool>,
    bell: Arc<Bell>,
    thread: Option<JoinHandle<()>>,
}

/// When a subscription looks.
enum Pace {
    OnNews,
    Every(Duration),
}

impl<T: Message> Reader<T> {
    /// The newest sample.
    pub fn read(&mut self) -> Flow<&T> {
        self.input.freeze(self.beyond.now());
        self.input.read()
    }

    /// All that came since the last look.
    pub fn all(&mut self) -> &[T] {
        self.input.freeze(self.beyond.now());
        self.input.all()
    }

    /// Waits until a sample comes, or so long. Says whether one has come since the last wait.
    pub fn wait(&self, at_most: Duration) -> bool {
        self.bell.wait(at_most)
    }

    /// How many samples had to go for want of room.
    pub fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    /// Tells an observer every sample that comes, when it comes.
    pub fn on_news(self, observer: impl FnMut(&T) + Send + 'static) -> Subscription {
        self.subscribe(Pace::OnNews, observer)
    }

    /// Looks every so often, and tells an observer what has come since. Of a data connection that is the newest sample
    /// alone: to see each, look at least twice as often as they are written.
    pub fn every(
        self,
        period: Duration,
        observer: impl FnMut(&T) + Send + 'static,
    ) -> Subscription {
        self.subscribe(Pace::Every(period), observer)
    }

    fn subscribe(
        mut self,
        pace: Pace,
        mut observer: impl FnMut(&T) + Send + 'static,
    ) -> Subscription {
        let ended = Arc::new(AtomicBool::new(false));
        let bell = Arc::clone(&self.bell);
        let ending = Arc::clone(&ended);
        let name = format!("reads {}", self.port);
        let work = move || {
            let mut due = Instant::now();
            while !ending.load(Ordering::Acquire) && self.beyond.is_there() {
                match pace {
                    Pace::OnNews => {
                        self.wait(NAP);
                    }
                    Pace::Every(period) => {
                        let now = Instant::now();
                        if now < due {
                            std::thread::park_timeout(due - now);
                            continue;
                        }
                        due = (due + period).max(now);
                    }
                }
                self.all().iter().for_each(&mut observer);
            }
        };
        Subscription {
            ended,
            bell,
            thread: std::thread::Builder::new().name(name).spawn(work).ok(),
        }
    }
}

impl Drop for Subscription {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Release);
        self.bell.ring();
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // An observer that has panicked has ended it before.
            let _ = thread.join();
        }
    }
}
