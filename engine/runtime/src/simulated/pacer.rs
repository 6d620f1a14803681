//! The pacer delays virtual time to keep it in step with real time. The only user of the real clock here; it only
//! sleeps.

use std::time::{Duration, Instant};

use asmotion_port::Time;

/// Speed of virtual time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Pace {
    /// As fast as the machine allows.
    #[default]
    Unlimited,
    /// Virtual seconds per real second.
    Factor(f64),
}

/// Delays virtual time, counting from the moment the pace was set.
pub(super) struct Pacer {
    start_time: Time,
    start_instant: Instant,
    factor: f64,
}

impl Pacer {
    pub(super) fn new(start_time: Time, factor: f64) -> Self {
        Self {
            start_time,
            start_instant: Instant::now(),
            factor,
        }
    }

    /// Sets the current virtual time.
    pub(super) fn restart(&mut self, now: Time) {
        self.start_time = now;
        self.start_instant = Instant::now();
    }

    /// Sleeps until the real clock allows virtual time to be `at`.
    pub(super) fn wait(&self, at: Time) {
        let seconds = at.since(self.start_time).as_secs_f64() / self.factor;
        let Ok(after) = Duration::try_from_secs_f64(seconds) else {
            return;
        };
        std::thread::sleep(after.saturating_sub(self.start_instant.elapsed()));
    }
}
