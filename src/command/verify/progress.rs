//! Progress of an exploration.

use super::words::{counted, number};
use asmotion_verify::Progress;
use std::time::Duration;

/// A line about an exploration in progress.
pub fn line(progress: &Progress, time: Duration) -> String {
    let rate = progress.states as f64 / time.as_secs_f64().max(0.001);
    let waiting = progress.states.saturating_sub(progress.explored);
    format!(
        "   Exploring {}, {} not explored yet, {}, {} a second, {} MiB",
        counted(progress.states, "state"),
        number(waiting),
        counted(progress.depth.into(), "step"),
        number(rate as u64),
        progress.memory >> 20,
    )
}
