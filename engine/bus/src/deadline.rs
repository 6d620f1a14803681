//! Deadlines on the monotonic clock.

use std::time::{Duration, Instant};

/// The instant this much later; a year from now, if the clock has no such instant.
pub fn later(by: Duration) -> Instant {
    let now = Instant::now();
    let year = Duration::from_secs(365 * 24 * 3600);
    now.checked_add(by).unwrap_or_else(|| now + year)
}
