//! The work of a writer between its messages: discards those that nobody reads in time, and shows the layout to a reader
//! that starts again while the writer is quiet.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use asmotion_datum::DatumError;
use asmotion_runtime::SinkUpkeep;

use super::{WriterState, lock, problem, to_datum_error};
use crate::error::QueueCheckError;
use crate::queue::{HolderAccess, KernelQueue, QueueHolder, QueueOrigin};

/// Pause before the next search for readers; doubled after each search without a result.
const SEARCH: Duration = Duration::from_millis(100);
/// Longest pause between two searches.
const LONGEST_SEARCH: Duration = Duration::from_secs(5);
/// Time without a message after which the writer is quiet.
const QUIET: Duration = Duration::from_secs(1);

/// The upkeep of a writer's queue, in a thread other than the writer's.
pub(super) struct QueueUpkeep {
    state: Arc<Mutex<WriterState>>,
    /// The descriptors of readers found by the last search.
    readers: Vec<QueueHolder>,
    /// Number of messages sent at the last search, if the queue was empty then and has been since: a reader that this
    /// search has not found has received nothing.
    settled: Option<u64>,
    /// Number of messages sent at the last call, and the time at which it changed.
    sent: u64,
    changed: Instant,
    search_at: Instant,
    pause: Duration,
    /// The last problem, so that it is reported once.
    problem: Option<QueueCheckError>,
}

/// Part of the state that the upkeep needs.
struct QueueStatus {
    queue: Arc<KernelQueue>,
    /// Number of messages sent so far.
    sent: u64,
    is_empty: bool,
}

impl QueueUpkeep {
    pub(super) fn new(state: Arc<Mutex<WriterState>>) -> Self {
        Self {
            state,
            readers: Vec::new(),
            settled: None,
            sent: 0,
            changed: Instant::now(),
            search_at: Instant::now(),
            pause: SEARCH,
            problem: None,
        }
    }

    /// Discards old messages, and opens a new queue if the name of this one was removed.
    fn update(
        &self,
        report: &mut dyn FnMut(u64, &DatumError),
    ) -> Result<QueueStatus, QueueCheckError> {
        let mut state = lock(&self.state);
        if state.queue.is_unlinked() {
            state.reopen()?;
        }
        state.expire(Instant::now())?;
        let is_empty = state.update_taken() == 0;
        let discarded = std::mem::take(&mut state.discarded);
        let status = QueueStatus {
            queue: Arc::clone(&state.queue),
            sent: state.sent,
            is_empty,
        };
        let max_age = state.max_age.unwrap_or_default();
        drop(state);
        if discarded.left > 0 {
            let reason = "left in the queue by an earlier writer";
            report(discarded.left, &problem(reason.to_owned()));
        }
        if discarded.expired > 0 {
            let reason = format!("not read within {max_age:?}");
            report(discarded.expired, &problem(reason));
        }
        Ok(status)
    }

    /// Follows the readers, and shows the layout if the next one would otherwise wait for it in vain: all known readers
    /// are gone and a new one has received nothing, or nobody has the queue open.
    fn follow(&mut self, status: &QueueStatus) -> Result<(), QueueCheckError> {
        let now = Instant::now();
        if status.sent != self.sent {
            self.sent = status.sent;
            self.changed = now;
        }
        if !status.is_empty || self.settled != Some(status.sent) {
            self.settled = None;
        }
        let is_held = |reader| status.queue.is_held_by(reader);
        let are_gone = !self.readers.is_empty() && !self.readers.iter().any(is_held);
        let is_quiet = status.is_empty && now.saturating_duration_since(self.changed) >= QUIET;
        let is_due = self.readers.is_empty() || (is_quiet && self.settled.is_none());
        if !(are_gone || is_due && now >= self.search_at) {
            return Ok(());
        }
        // without the lock: a search takes milliseconds
        let others = status.queue.find_holders(HolderAccess::Any);
        self.pause = if others.found.is_empty() {
            (2 * self.pause).min(LONGEST_SEARCH)
        } else {
            SEARCH
        };
        self.search_at = now + self.pause;
        let mut state = lock(&self.state);
        state.holder_seen |= !others.found.is_empty();
        let is_empty = status.is_empty && state.update_taken() == 0 && state.sent == status.sent;
        let nobody = others.found.is_empty() && state.is_unread(others.complete);
        let all_new = are_gone && self.settled.is_some();
        if is_empty && (nobody || all_new) {
            state.show_layout()?;
        }
        self.settled = (is_empty && state.queue.count() == 0).then_some(status.sent);
        self.readers = others.found;
        Ok(())
    }
}

impl WriterState {
    /// Opens or creates the queue of this name again.
    fn reopen(&mut self) -> Result<(), QueueCheckError> {
        let (queue, origin) = KernelQueue::create(&self.name, self.capacity)?;
        if queue.size() < self.capacity.size {
            return Err(QueueCheckError::Smaller {
                queue: self.name.to_string(),
                required: queue.size(),
                size: self.capacity.size,
            });
        }
        self.removed.resize(queue.size(), 0);
        self.queue = Arc::new(queue);
        self.origin = origin;
        self.waiting.clear();
        self.taken = 0;
        match origin {
            QueueOrigin::Created => self.show_layout(),
            QueueOrigin::Found => Ok(()),
        }
    }
}

impl SinkUpkeep for QueueUpkeep {
    fn tend(&mut self, report: &mut dyn FnMut(u64, &DatumError)) {
        let status = self.update(report);
        let problem = status.and_then(|status| self.follow(&status)).err();
        if let Some(problem) = &problem
            && self.problem.as_ref() != Some(problem)
        {
            report(0, &to_datum_error(problem.clone()));
        }
        self.problem = problem;
    }
}
