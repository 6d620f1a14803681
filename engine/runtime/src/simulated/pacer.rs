//! The pacer: holds virtual time back to real time. The one place here that knows real time; it only sleeps.

use std::time::{Duration, Instant};

use asmotion_port::Time;

/// How fast virtual time passes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Pace {
    /// As fast as the machine can.
    #[default]
    Unlimited,
    /// So many virtual seconds in a real one.
    Factor(f64),
}

/// Holds virtual time back to a pace.
pub(super) struct Pacer {
    from: Time,
    since: Instant,
    factor: f64,
}

impl Pacer {
    pub(super) fn new(from: Time, factor: f64) -> Self {
        Self {
            from,
            since: Instant::now(),
            factor,
        }
    }

    /// Virtual time is this from now on.
    pub(super) fn begin_at(&mut self, now: Time) {
        self.from = now;
        self.since = Instant::now();
    }

    /// Sleeps until virtual time may be `at`.
    pub(super) fn wait(&self, at: Time) {
        let seconds = at.since(self.from).as_secs_f64() / self.factor;
        let Ok(after) = Duration::try_from_secs_f64(seconds) else {
            return;
        };
        std::thread::sleep(after.saturating_sub(self.since.elapsed()));
    }
}
