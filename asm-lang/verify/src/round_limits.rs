//! Limits within a round of an exploration: a single node can have many successors, and a state many combinations of inputs.

use crate::explore::{Incomplete, Limits, Progress};
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Number of executions of a step, or of evaluations of the conditions, after which a thread examines the limits.
const INTERVAL: u32 = 32;

/// The state of a round that its threads share.
#[derive(Debug)]
pub(crate) struct RoundLimits {
    /// Memory that the exploration takes besides the round, and its limit, in bytes.
    before: u64,
    limit: Option<u64>,
    /// The progress when the round began.
    progress: Progress,
    /// Memory that the round takes so far, in bytes.
    bytes: AtomicU64,
    has_ended: AtomicBool,
    reason: Mutex<Option<Incomplete>>,
}

impl RoundLimits {
    pub fn new(limits: Limits, progress: Progress) -> Self {
        Self {
            before: progress.memory,
            limit: limits.memory,
            progress,
            bytes: AtomicU64::new(0),
            has_ended: AtomicBool::new(false),
            reason: Mutex::new(None),
        }
    }

    /// Returns the limit that ended the round.
    pub fn ended(&self) -> Option<Incomplete> {
        *self.reason.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn end(&self, reason: Incomplete) {
        let mut known = self.reason.lock().unwrap_or_else(PoisonError::into_inner);
        known.get_or_insert(reason);
        self.has_ended.store(true, Ordering::Relaxed);
    }
}

/// The limits as a thread examines them.
pub(crate) struct ExaminedLimits<'a> {
    round: &'a RoundLimits,
    /// Called with the progress by the thread of the exploration; returns `false` to end.
    proceed: Option<&'a mut dyn FnMut(Progress) -> bool>,
    /// Executions and evaluations since the limits were examined, and the bytes that they take.
    since: u32,
    bytes: u64,
}

impl<'a> ExaminedLimits<'a> {
    pub fn new(
        round: &'a RoundLimits,
        proceed: Option<&'a mut dyn FnMut(Progress) -> bool>,
    ) -> Self {
        Self {
            round,
            proceed,
            since: 0,
            bytes: 0,
        }
    }

    /// Notes an execution or evaluation whose result takes this memory. Returns `false` if the round ends.
    #[inline]
    pub fn goes_on(&mut self, bytes: usize) -> bool {
        self.bytes += bytes as u64;
        self.since += 1;
        if self.since >= INTERVAL {
            self.examine();
        }
        !self.round.has_ended.load(Ordering::Relaxed)
    }

    #[cold]
    fn examine(&mut self) {
        self.since = 0;
        let own = std::mem::take(&mut self.bytes);
        let round = self.round;
        let bytes = round.bytes.fetch_add(own, Ordering::Relaxed) + own;
        let memory = round.before.saturating_add(bytes);
        if round.limit.is_some_and(|limit| memory > limit) {
            round.end(Incomplete::Memory);
        }
        let progress = Progress {
            memory,
            ..round.progress
        };
        if let Some(proceed) = &mut self.proceed
            && !proceed(progress)
        {
            round.end(Incomplete::Stopped);
        }
    }
}
