//! Port readers: threads outside of a system that read one of its outputs, each by a connection of its own.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use asmotion_datum::Message;
use asmotion_port::{AnyInput, Flow, InputPort, Notifier};

use crate::handle::RunHandle;

/// The longest sleep without a look at `ended`.
const NAP: Duration = Duration::from_millis(100);

/// Reads an output port from outside of the system; see [`Run::reader`](crate::Run::reader). Every look is a cycle of
/// its own: what was new at the last one is old.
pub struct PortReader<T: Message> {
    pub(super) port: String,
    pub(super) input: InputPort<T>,
    /// Notified of every sample. The writer holds it weakly: it keeps the connection as long as this reader exists.
    pub(super) notifier: Arc<Notifier>,
    pub(super) dropped: Arc<AtomicU64>,
    pub(super) handle: Arc<dyn RunHandle>,
}

/// A thread that gives an observer what comes. Dropping this ends it: sets `ended`, wakes the thread, joins it.
#[must_use = "it ends when it is dropped"]
pub struct PortSubscription {
    ended: Arc<AtomicBool>,
    notifier: Arc<Notifier>,
    thread: Option<JoinHandle<()>>,
}

/// When a subscription looks.
enum SubscriptionPace {
    OnNews,
    Every(Duration),
}

impl<T: Message> PortReader<T> {
    /// The newest sample.
    pub fn read(&mut self) -> Flow<&T> {
        self.input.freeze(self.handle.now());
        self.input.read()
    }

    /// All that came since the last look.
    pub fn all(&mut self) -> &[T] {
        self.input.freeze(self.handle.now());
        self.input.all()
    }

    /// Waits until a sample comes, or so long. Says whether one has come since the last wait.
    pub fn wait(&self, at_most: Duration) -> bool {
        self.notifier.wait(at_most)
    }

    /// How many samples had to go for want of room.
    pub fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    /// Gives an observer every sample when it comes, in a thread of its own.
    pub fn on_news(self, observer: impl FnMut(&T) + Send + 'static) -> PortSubscription {
        self.subscribe(SubscriptionPace::OnNews, observer)
    }

    /// Looks once a period, in a thread of its own, and gives an observer what has come since. Of a data connection that is the newest sample
    /// alone: to see each, look at least twice as often as they are written.
    pub fn every(
        self,
        period: Duration,
        observer: impl FnMut(&T) + Send + 'static,
    ) -> PortSubscription {
        self.subscribe(SubscriptionPace::Every(period), observer)
    }

    fn subscribe(
        mut self,
        pace: SubscriptionPace,
        mut observer: impl FnMut(&T) + Send + 'static,
    ) -> PortSubscription {
        let ended = Arc::new(AtomicBool::new(false));
        let notifier = Arc::clone(&self.notifier);
        let ending = Arc::clone(&ended);
        let name = format!("reads {}", self.port);
        let work = move || {
            let mut due = Instant::now();
            while !ending.load(Ordering::Acquire) && self.handle.is_running() {
                match pace {
                    SubscriptionPace::OnNews => {
                        self.wait(NAP);
                    }
                    SubscriptionPace::Every(period) => {
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
        PortSubscription {
            ended,
            notifier,
            thread: std::thread::Builder::new().name(name).spawn(work).ok(),
        }
    }
}

impl Drop for PortSubscription {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Release);
        self.notifier.notify();
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // An observer that has panicked has ended it before.
            let _ = thread.join();
        }
    }
}
