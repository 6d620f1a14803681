//! At what time the steps of a run are done.

use std::fmt;

/// The clock of a run. What tells the real time comes from outside: the language has no clock.
#[derive(Default)]
pub enum SimulationClock {
    /// Time stands still, but for what scripts and recordings say.
    #[default]
    Virtual,
    /// So many nanoseconds pass from step to step; none before the first.
    Stepped(i64),
    /// The nanoseconds since the run began, asked for at each step.
    Told(Box<dyn FnMut() -> i64 + Send>),
}

impl SimulationClock {
    /// The time of a step, counted from 1, in nanoseconds.
    pub fn now(&mut self, step: u64) -> i64 {
        match self {
            Self::Virtual => 0,
            Self::Stepped(unit) => {
                let passed = i64::try_from(step.saturating_sub(1)).unwrap_or(i64::MAX);
                unit.saturating_mul(passed)
            }
            Self::Told(tell) => tell(),
        }
    }
}

impl fmt::Debug for SimulationClock {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Virtual => to.write_str("Virtual"),
            Self::Stepped(unit) => write!(to, "Stepped({unit})"),
            Self::Told(_) => to.write_str("Told"),
        }
    }
}
