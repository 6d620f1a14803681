use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Mission cannot start
///
/// The mission file or its composite cannot be read, the profile does not exist, or the composite cannot be assembled in this
/// build.
///
/// `robot.composite.toml` runs a specification whose `mode` becomes `BUSY` when `true` arrives on `start`.
///
/// ```toml mission wrong
/// schema = "mission/1"
/// composite = "robot.composite.toml"
/// profile = "lab"
/// limit_s = 2
///
/// [[at]]
/// time_s = 1
/// write = "topic:start"
/// value = { data = true }
///
/// [[expect]]
/// eventually = "Robot.mode = BUSY"
/// ```
///
/// Corrected:
///
/// ```toml mission corrected
/// schema = "mission/1"
/// composite = "robot.composite.toml"
/// limit_s = 2
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
#[code(V036, error)]
#[error("{reason}")]
pub struct MissionNotStarted {
    pub reason: String,
    /// Way out.
    pub help: Option<String>,
    /// The composite in the mission file, or its profile; `None` if the file cannot be read.
    pub at: Option<Span>,
}

impl Finding for MissionNotStarted {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let diagnostic = match self.at {
            Some(at) => diagnostic.label(at, "run by this mission"),
            None => diagnostic,
        };
        match &self.help {
            Some(help) => diagnostic.help(help.clone()),
            None => diagnostic,
        }
    }
}
