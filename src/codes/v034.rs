use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Action of a mission failed
///
/// The running system refused an action: a value of a wrong type, a transition that the present state does not allow, or an
/// action whose time or condition did not come before the end of the mission.
///
/// `robot.composite.toml` runs a specification whose `mode` becomes `BUSY` when `true` arrives on `start`.
///
/// ```toml mission wrong
/// schema = "mission/1"
/// composite = "robot.composite.toml"
/// limit_s = 2
///
/// [[at]]
/// time_s = 5
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
#[code(V034, error)]
#[error("{reason}")]
pub struct ActionFailed {
    pub reason: String,
    pub at: Span,
}

impl Finding for ActionFailed {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic.label(self.at, "this action")
    }
}
