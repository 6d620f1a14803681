//! Delays between attempts: growing, and jittered so that several clients do not reconnect in step.

use std::time::Duration;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Delays between connection attempts: growing, and jittered.
pub(crate) struct Backoff {
    first: Duration,
    last: Duration,
    next: Duration,
    chance: ChaCha8Rng,
}

impl Backoff {
    /// Creates delays between two limits; the seed determines the jitter.
    pub(crate) fn new(first: Duration, last: Duration, seed: u64) -> Self {
        Self {
            first,
            last,
            next: first,
            chance: ChaCha8Rng::seed_from_u64(seed),
        }
    }

    /// Resets the delay after a successful attempt.
    pub(crate) fn reset(&mut self) {
        self.next = self.first;
    }

    /// Returns the next delay: half of it is fixed, the other half random. Doubles the following one.
    pub(crate) fn wait(&mut self) -> Duration {
        let wait = self.next;
        self.next = (wait * 2).min(self.last);
        wait.mul_f64(self.chance.random_range(0.5..1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waits_grow_to_a_limit_and_differ_by_seed_alone() {
        let waits = |seed| {
            let mut backoff =
                Backoff::new(Duration::from_millis(100), Duration::from_secs(2), seed);
            (0..8).map(|_| backoff.wait()).collect::<Vec<_>>()
        };
        assert_eq!(waits(1), waits(1));
        assert_ne!(waits(1), waits(2));
        for (n, wait) in waits(1).into_iter().enumerate() {
            let full = Duration::from_millis(100 << n).min(Duration::from_secs(2));
            assert!(wait >= full / 2 && wait < full, "{n}: {wait:?}");
        }
    }
}
