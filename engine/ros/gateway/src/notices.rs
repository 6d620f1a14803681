//! Events of a node that a bridge has not reported, and the causes that it has.

use std::collections::BTreeSet;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::bus_topic::readable;

/// Notices that wait for the next cycle of a bridge. A cause that repeats is reported once.
#[derive(Default)]
pub(crate) struct Notices(Mutex<KeptNotices>);

#[derive(Default)]
struct KeptNotices {
    waiting: Vec<String>,
    /// Causes since the last [`forget`](Notices::forget).
    reported: BTreeSet<String>,
}

/// Number of different causes that are kept; later ones are not reported.
const KEPT: usize = 64;

impl Notices {
    fn lock(&self) -> MutexGuard<'_, KeptNotices> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Keeps a notice, unless it repeats another. Returns whether it is new.
    pub(crate) fn keep(&self, text: String) -> bool {
        let text = readable(&text);
        let mut kept = self.lock();
        if kept.reported.len() >= KEPT || !kept.reported.insert(text.clone()) {
            return false;
        }
        kept.waiting.push(text);
        true
    }

    /// Begins anew: a cause that was reported before is reported again.
    pub(crate) fn forget(&self) {
        self.lock().reported.clear();
    }

    pub(crate) fn take(&self) -> Vec<String> {
        std::mem::take(&mut self.lock().waiting)
    }
}
