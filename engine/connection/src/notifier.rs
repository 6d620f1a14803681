//! A notifier: wakes the one thread that waits for any of several queues.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread::Thread;
use std::time::Duration;

/// Wakes a waiting thread. Notifying never blocks for longer than the waiter needs to store its thread handle.
///
/// Any thread may notify; one thread at a time waits. No notification is lost: the notifier stores `notified` before it
/// reads `waiting`, and the waiter stores `waiting` before it reads `notified`. Both flags are `SeqCst`, so of two
/// threads that store one flag and read the other at least one reads what the other has stored: either the waiter does
/// not sleep, or it is unparked. (With `Release` and `Acquire` alone both could read the old value, and the waiter
/// would sleep its full time.) An unpark that comes before the park makes the park return at once.
#[derive(Default)]
pub struct Notifier {
    /// Set by `notify`; cleared by the waiter when its wait ends.
    notified: AtomicBool,
    /// Set by the waiter before it sleeps; taken by the first `notify` after that, so that a burst of notifications
    /// takes the lock once.
    waiting: AtomicBool,
    /// The waiter's thread. Held only to store or to unpark it.
    thread: Mutex<Option<Thread>>,
    /// Called by `notify` in the notifying thread, before the flag is set.
    callback: Option<Box<dyn Fn() + Send + Sync>>,
}

impl Notifier {
    /// Creates a notifier that has not been notified.
    pub fn new() -> Self {
        Self::default()
    }

    /// Creates a notifier that calls a function in the notifying thread, for uses without a thread to wake. The
    /// function must return soon and must not block.
    pub fn calling(callback: impl Fn() + Send + Sync + 'static) -> Self {
        Self {
            callback: Some(Box::new(callback)),
            ..Self::default()
        }
    }

    /// Ends the current wait or, if there is none, the next one.
    pub fn notify(&self) {
        if let Some(callback) = &self.callback {
            callback();
        }
        self.notified.store(true, Ordering::SeqCst);
        if self.waiting.swap(false, Ordering::SeqCst)
            && let Some(thread) = &*self.thread.lock().unwrap_or_else(PoisonError::into_inner)
        {
            thread.unpark();
        }
    }

    /// Waits for a notification, at most this long. Returns whether there was one since the last wait. Only one thread
    /// may wait at a time: the wait of a second thread may last its full time.
    pub fn wait(&self, timeout: Duration) -> bool {
        *self.thread.lock().unwrap_or_else(PoisonError::into_inner) = Some(std::thread::current());
        self.waiting.store(true, Ordering::SeqCst);
        if !self.notified.load(Ordering::SeqCst) {
            std::thread::park_timeout(timeout);
        }
        self.waiting.store(false, Ordering::SeqCst);
        self.notified.swap(false, Ordering::SeqCst)
    }
}

impl fmt::Debug for Notifier {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Notifier")
            .field("notified", &self.notified)
            .finish_non_exhaustive()
    }
}

#[cfg(all(test, not(feature = "loom")))]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::AtomicU32;
    use std::time::Instant;

    use super::*;

    /// Longer than any test waits for another thread.
    const LONG: Duration = Duration::from_secs(60);

    #[test]
    fn a_notification_ends_the_next_wait_and_no_other() {
        let notifier = Notifier::new();
        assert!(!notifier.wait(Duration::ZERO));
        notifier.notify();
        notifier.notify();
        let begun = Instant::now();
        assert!(notifier.wait(LONG));
        assert!(begun.elapsed() < LONG);
        assert!(!notifier.wait(Duration::ZERO));
    }

    #[test]
    fn a_notification_ends_the_wait_of_another_thread() {
        let notifier = Arc::new(Notifier::new());
        let waiting = Arc::clone(&notifier);
        let begun = Instant::now();
        let waiter = std::thread::spawn(move || waiting.wait(LONG));
        while !notifier.waiting.load(Ordering::SeqCst) {
            std::thread::yield_now();
        }
        notifier.notify();
        assert!(waiter.join().unwrap());
        assert!(begun.elapsed() < LONG);
    }

    #[test]
    fn a_wait_without_notification_ends_at_its_timeout() {
        let timeout = Duration::from_millis(20);
        let begun = Instant::now();
        // a thread may be unparked without reason
        while begun.elapsed() < timeout {
            assert!(!Notifier::new().wait(timeout));
        }
    }

    #[test]
    fn each_notification_calls_the_function() {
        let count = Arc::new(AtomicU32::new(0));
        let counted = Arc::clone(&count);
        let notifier = Notifier::calling(move || {
            counted.fetch_add(1, Ordering::SeqCst);
        });
        notifier.notify();
        notifier.notify();
        assert_eq!(count.load(Ordering::SeqCst), 2);
        assert!(format!("{notifier:?}").contains("notified: true"));
    }
}
