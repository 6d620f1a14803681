//! Outcomes of missions.

/// Outcome of a mission.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MissionOutcome {
    /// A success condition was met.
    Reached,
    /// A failure condition was met.
    Failed,
    /// The time limit was reached before a success condition was met.
    TimeUp,
    /// The time limit of a run without success conditions was reached.
    Completed,
    /// A component failed: one without which nothing can be reached, or another one, and the time limit was reached.
    Fault,
    /// The run was stopped from outside.
    Stopped,
}

impl MissionOutcome {
    /// The outcome in words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reached => "reached",
            Self::Failed => "failed",
            Self::TimeUp => "time up",
            Self::Completed => "completed",
            Self::Fault => "fault",
            Self::Stopped => "stopped",
        }
    }
}
