use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Expectation of a mission failed
///
/// The run does not fulfil the requirement. The message shows the time and the values at that time. An expectation that
/// never began, or whose values were never known, fails as well: it would not notice any error.
///
/// `robot.composite.toml` runs a specification whose `mode` becomes `BUSY` when `true` arrives on `start`.
///
/// ```toml mission wrong
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
/// within_s = 0.5
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
#[code(V033, error)]
#[error("{name}: {problem}")]
pub struct ExpectationFailed {
    /// Description of the expectation, or its condition.
    pub name: String,
    pub problem: String,
    /// Values of the condition's operands.
    pub values: String,
    pub at: Span,
    /// Location of the condition that never began it.
    pub after: Option<Span>,
}

impl Finding for ExpectationFailed {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let diagnostic = diagnostic.label(self.at, self.values.clone());
        match self.after {
            Some(after) => diagnostic.label(after, "did not become true"),
            None => diagnostic,
        }
    }
}
