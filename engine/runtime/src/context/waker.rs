//! Waking a component's thread: a flag and an unpark; nothing blocks.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::Thread;

/// How other threads reach a component's thread.
///
/// A flag is set before the unpark, and the component's thread takes the flags before it parks. If the flag is set after
/// the thread has looked, the unpark comes after that too: the park that follows returns at once, and the thread looks
/// again. So no wake-up is lost, and none needs a lock.
#[derive(Default)]
pub(crate) struct ThreadWaker {
    /// Whether new data make the component cycle. Stored by the component's thread when its drive changes, read by those
    /// who bring data. `Relaxed`: a sample that comes at the very moment
    /// of the change may wait for the next trigger, as one that came just before it would.
    event_driven: AtomicBool,
    /// Something new is there. Set by any thread, taken by the component's. The swap lets only the first of several
    /// triggers unpark, and publishes (`AcqRel`) the data put into queues before it.
    triggered: AtomicBool,
    /// A cycle was asked for by hand. Set by the run's owner, taken by the component's thread.
    called: AtomicBool,
    /// The thread to unpark. Set once by the thread that spawned it, and before any of its components is
    /// started, so that nothing needs to wake it earlier.
    thread: OnceLock<Thread>,
}

impl ThreadWaker {
    pub(crate) fn set_thread(&self, thread: Thread) {
        // Set once, by the one who spawned it.
        let _ = self.thread.set(thread);
    }

    pub(crate) fn set_event_driven(&self, event_driven: bool) {
        self.event_driven.store(event_driven, Ordering::Relaxed);
    }

    /// Something new is there: an event-driven component cycles.
    pub(crate) fn trigger(&self) {
        if self.event_driven.load(Ordering::Relaxed) && !self.triggered.swap(true, Ordering::AcqRel)
        {
            self.unpark();
        }
    }

    /// A cycle is wanted, whatever drives the component.
    pub(crate) fn call(&self) {
        self.called.store(true, Ordering::Release);
        self.unpark();
    }

    pub(crate) fn unpark(&self) {
        if let Some(thread) = self.thread.get() {
            thread.unpark();
        }
    }

    pub(crate) fn take_trigger(&self) -> bool {
        self.triggered.swap(false, Ordering::AcqRel)
    }

    pub(crate) fn take_call(&self) -> bool {
        self.called.swap(false, Ordering::AcqRel)
    }
}
