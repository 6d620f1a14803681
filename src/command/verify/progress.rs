//! Progress of an exploration.

use crate::numbers::{counted, number};
use crate::terminal::TerminalOutput;
use asmotion_verify::Progress;
use std::time::{Duration, Instant};

/// Time between two lines of progress.
const INTERVAL: Duration = Duration::from_secs(2);

/// Number of states by which the states that wait have become fewer, from which an estimate is made.
const MIN_DONE: u64 = 50;

/// The progress of one exploration.
pub struct ExplorationProgress {
    begun: Instant,
    shown: Instant,
    /// States that were not explored yet when the last line was shown.
    waiting: u64,
    /// Limit for the memory, in bytes.
    memory: u64,
}

impl ExplorationProgress {
    /// Starts the time.
    pub fn new(memory: u64) -> Self {
        let begun = Instant::now();
        Self {
            begun,
            shown: begun,
            waiting: 0,
            memory,
        }
    }

    /// Returns the time since the start.
    pub fn elapsed(&self) -> Duration {
        self.begun.elapsed()
    }

    /// Shows a line now and then.
    pub fn show(&mut self, progress: &Progress, terminal: &mut TerminalOutput) {
        let now = Instant::now();
        let since = now - self.shown;
        if since > INTERVAL {
            terminal.progress(self.line(progress, now - self.begun, since));
            self.shown = now;
            self.waiting = progress.states.saturating_sub(progress.explored);
        }
    }

    /// A line about an exploration, `time` after its start and `since` after the last line.
    fn line(&self, progress: &Progress, time: Duration, since: Duration) -> String {
        let rate = progress.states as f64 / time.as_secs_f64().max(0.001);
        let waiting = progress.states.saturating_sub(progress.explored);
        format!(
            "   Exploring {}, {} not explored yet, {}, {} a second, {} MiB{}",
            counted(progress.states, "state"),
            number(waiting),
            counted(progress.depth.into(), "step"),
            number(rate as u64),
            progress.memory >> 20,
            self.estimate(progress, waiting, time, since),
        )
    }

    /// The time that is left: until all states are explored, if fewer wait than before, or until the memory is full.
    fn estimate(
        &self,
        progress: &Progress,
        waiting: u64,
        time: Duration,
        since: Duration,
    ) -> String {
        let done = self.waiting.saturating_sub(waiting);
        // properties are decided when no state waits any more; a few states more or less say nothing
        if done >= MIN_DONE && waiting > 0 {
            let seconds = waiting as f64 / done as f64 * since.as_secs_f64();
            return format!(", done in about {}", rounded(seconds));
        }
        let left = self.memory.saturating_sub(progress.memory);
        if self.memory == 0 || progress.memory == 0 {
            return String::new();
        }
        let seconds = left as f64 / progress.memory as f64 * time.as_secs_f64();
        format!(", memory for about {} more", rounded(seconds))
    }
}

fn rounded(seconds: f64) -> String {
    if seconds < 90.0 {
        format!("{} s", seconds.ceil() as u64)
    } else {
        format!("{} min", (seconds / 60.0).ceil() as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_estimate_follows_the_frontier_or_the_memory() {
        let mut exploration = ExplorationProgress::new(100 << 20);
        let progress = Progress {
            states: 1000,
            explored: 600,
            transitions: 2000,
            depth: 7,
            memory: 25 << 20,
        };
        let (time, since) = (Duration::from_secs(10), Duration::from_secs(2));
        assert_eq!(
            exploration.line(&progress, time, since),
            "   Exploring 1,000 states, 400 not explored yet, 7 steps, 100 a second, 25 MiB, memory for about 30 s more"
        );
        exploration.waiting = 500;
        assert!(
            exploration
                .line(&progress, time, since)
                .ends_with("25 MiB, done in about 8 s")
        );
    }
}
