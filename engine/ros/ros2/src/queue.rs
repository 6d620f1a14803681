//! A bounded queue between the thread of a node and others.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use crate::notice::Waker;

/// A queue that drops its oldest element when it is full, and counts what it dropped.
pub(crate) struct Queue<T> {
    inside: Mutex<Inside<T>>,
    filled: Condvar,
    waker: OnceLock<Waker>,
    capacity: usize,
}

struct Inside<T> {
    elements: VecDeque<T>,
    dropped: u64,
}

impl<T> Queue<T> {
    pub(crate) fn new(capacity: usize) -> Self {
        Self {
            inside: Mutex::new(Inside {
                elements: VecDeque::new(),
                dropped: 0,
            }),
            filled: Condvar::new(),
            waker: OnceLock::new(),
            capacity: capacity.max(1),
        }
    }

    /// Sets what is called after an element has been put into the queue. Only the first one counts.
    pub(crate) fn set_waker(&self, waker: Waker) {
        self.waker.get_or_init(|| waker);
    }

    pub(crate) fn push(&self, element: T) {
        let mut inside = self.inside.lock().unwrap_or_else(PoisonError::into_inner);
        if inside.elements.len() >= self.capacity {
            inside.elements.pop_front();
            inside.dropped += 1;
        }
        inside.elements.push_back(element);
        drop(inside);
        self.filled.notify_one();
        if let Some(waker) = self.waker.get() {
            waker();
        }
    }

    pub(crate) fn take(&self) -> Option<T> {
        let mut inside = self.inside.lock().unwrap_or_else(PoisonError::into_inner);
        inside.elements.pop_front()
    }

    /// Waits for an element, at most for `longest`.
    pub(crate) fn wait(&self, longest: Duration) -> Option<T> {
        let end = Instant::now() + longest;
        let mut inside = self.inside.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            if let Some(element) = inside.elements.pop_front() {
                return Some(element);
            }
            let left = end.checked_duration_since(Instant::now())?;
            let waited = self.filled.wait_timeout(inside, left);
            inside = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    pub(crate) fn dropped(&self) -> u64 {
        self.inside
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .dropped
    }
}
