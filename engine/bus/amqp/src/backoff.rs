//! Delays between attempts: growing, and jittered so that several clients do not reconnect in step.

use std::time::Duration;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::settings::AmqpTiming;

/// Delays between connection attempts: growing, and jittered.
pub(crate) struct Backoff {
    first: Duration,
    last: Duration,
    next: Duration,
    jitter: f64,
    random: ChaCha8Rng,
}

impl Backoff {
    /// Creates delays between `first_retry` and `last_retry`; the seed determines the jitter.
    pub(crate) fn new(timing: &AmqpTiming, seed: u64) -> Self {
        Self {
            first: timing.first_retry,
            last: timing.last_retry,
            next: timing.first_retry,
            jitter: timing.jitter.clamp(0.0, 1.0),
            random: ChaCha8Rng::seed_from_u64(seed),
        }
    }

    /// Resets the delay after a successful attempt.
    pub(crate) fn reset(&mut self) {
        self.next = self.first;
    }

    /// Returns the next delay, of which the share `jitter` is random. Doubles the following one.
    pub(crate) fn next_delay(&mut self) -> Duration {
        let wait = self.next;
        self.next = (wait * 2).min(self.last);
        let random: f64 = self.random.random_range(0.0..1.0);
        wait.mul_f64(1.0 - self.jitter * (1.0 - random))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first delays, which begin at 100 ms and end at 2 s.
    fn waits(jitter: f64, seed: u64) -> Vec<Duration> {
        let timing = AmqpTiming {
            jitter,
            ..AmqpTiming::default()
        };
        let mut backoff = Backoff::new(&timing, seed);
        (0..8).map(|_| backoff.next_delay()).collect()
    }

    #[test]
    fn the_share_of_a_delay_that_is_random_is_the_jitter() {
        let full = [100, 200, 400, 800, 1600, 2000, 2000, 2000].map(Duration::from_millis);
        assert_eq!(waits(0.0, 1), full);
        for (wait, full) in waits(0.2, 1).into_iter().zip(full) {
            assert!(
                wait >= full.mul_f64(0.8) && wait < full,
                "{wait:?} of {full:?}"
            );
        }
        assert!(
            waits(1.0, 1)
                .iter()
                .zip(full)
                .any(|(wait, full)| *wait < full / 2)
        );
    }

    #[test]
    fn waits_grow_to_a_limit_and_differ_by_seed_alone() {
        let waits = |seed| waits(0.5, seed);
        assert_eq!(waits(1), waits(1));
        assert_ne!(waits(1), waits(2));
        for (n, wait) in waits(1).into_iter().enumerate() {
            let full = Duration::from_millis(100 << n).min(Duration::from_secs(2));
            assert!(wait >= full / 2 && wait < full, "{n}: {wait:?}");
        }
    }
}
