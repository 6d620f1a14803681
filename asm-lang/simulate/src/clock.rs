//! The times at which the steps of a run take place.

use std::fmt;

/// The clock of a run. Real time is passed in from outside, because the language reads no clock.
#[derive(Default)]
pub enum SimulationClock {
    /// The time is always 0. Recordings replace it, and scripts may set clock functions.
    #[default]
    Virtual,
    /// Each step is this number of nanoseconds later than the one before; the first is at 0.
    Stepped(i64),
    /// Calls a function at each step, which returns the nanoseconds since the start of the run.
    Told(Box<dyn FnMut() -> i64 + Send>),
}

impl SimulationClock {
    /// Returns the time of a step in nanoseconds. Steps are counted from 1.
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
