//! Deadlines on the monotonic clock.

use std::time::{Duration, Instant};

/// The instant this much later; a year from now, if the clock has no such instant.
pub fn deadline_after(timeout: Duration) -> Instant {
    let now = Instant::now();
    let year = Duration::from_secs(365 * 24 * 3600);
    now.checked_add(timeout).unwrap_or_else(|| now + year)
}
