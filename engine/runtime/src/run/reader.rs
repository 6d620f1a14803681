//! Port readers: threads outside a system that read one of its outputs, each through its own connection.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use asmotion_datum::Message;
use asmotion_port::{AnyInput, Flow, InputPort, Notifier};

use crate::handle::RunHandle;

/// Longest sleep between two checks of `ended`.
const NAP: Duration = Duration::from_millis(100);

/// Reads an output port from outside the system; see [`Run::reader`](crate::Run::reader). Each read freezes the
/// input again: a sample that is new at one read is old at the next.
pub struct PortReader<T: Message> {
    pub(super) port: String,
    pub(super) input: InputPort<T>,
    /// Notified of every sample. The writer holds a weak reference, so the connection ends with this reader.
    pub(super) notifier: Arc<Notifier>,
    pub(super) dropped: Arc<AtomicU64>,
    pub(super) handle: Arc<dyn RunHandle>,
}

/// A thread that passes samples to an observer. Dropping this sets `ended`, wakes the thread and joins it.
#[must_use = "it ends when it is dropped"]
pub struct PortSubscription {
    ended: Arc<AtomicBool>,
    notifier: Arc<Notifier>,
    thread: Option<JoinHandle<()>>,
}

/// Times at which a subscription reads.
enum SubscriptionPace {
    OnNewData,
    Every(Duration),
}

impl<T: Message> PortReader<T> {
    /// Reads the newest sample.
    pub fn read(&mut self) -> Flow<&T> {
        self.input.freeze(self.handle.now());
        self.input.read()
    }

    /// All samples that have arrived since the last read.
    pub fn all(&mut self) -> &[T] {
        self.input.freeze(self.handle.now());
        self.input.all()
    }

    /// Waits until a sample arrives, at most this long. Returns whether one has arrived since the last wait.
    pub fn wait(&self, timeout: Duration) -> bool {
        self.notifier.wait(timeout)
    }

    /// Number of samples dropped because the connection was full.
    pub fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    /// Passes every sample to an observer on arrival, in a thread of its own.
    pub fn on_new_data(self, observer: impl FnMut(&T) + Send + 'static) -> PortSubscription {
        self.subscribe(SubscriptionPace::OnNewData, observer)
    }

    /// Reads once a period in a thread of its own, and passes the samples that have arrived since to an observer. A
    /// data connection keeps only the newest sample: to see every sample, use a period of at most half the writer's.
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
                    SubscriptionPace::OnNewData => {
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
            // fails if the observer has panicked, which ended the thread
            let _ = thread.join();
        }
    }
}
