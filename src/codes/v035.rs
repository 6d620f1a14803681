use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Mission ended otherwise than expected
///
/// The end condition did not hold before the time limit, or a component failed that the mission does not list under
/// `may_fail`.
///
/// `robot.composite.toml` runs a specification whose `mode` becomes `BUSY` when `true` arrives on `start`.
///
/// ```toml mission wrong
/// schema = "mission/1"
/// composite = "robot.composite.toml"
/// limit_s = 2
/// end = "Robot.mode = BUSY"
///
/// [[expect]]
/// always = "Robot.mode = IDLE"
/// ```
///
/// Corrected:
///
/// ```toml mission corrected
/// schema = "mission/1"
/// composite = "robot.composite.toml"
/// limit_s = 2
/// end = "Robot.mode = BUSY"
///
/// [[at]]
/// time_s = 1
/// write = "topic:start"
/// value = { data = true }
///
/// [[expect]]
/// eventually = "Robot.mode = BUSY"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(V035, error)]
#[error("{problem}")]
pub struct MissionEndedEarly {
    pub problem: String,
    pub at: Option<Span>,
    /// Reasons for which the coordinators made no progress.
    pub help: Option<String>,
}

impl Finding for MissionEndedEarly {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let diagnostic = match self.at {
            Some(at) => diagnostic.label(at, "did not become true"),
            None => diagnostic,
        };
        match &self.help {
            Some(help) => diagnostic.help(help.clone()),
            None => diagnostic,
        }
    }
}
