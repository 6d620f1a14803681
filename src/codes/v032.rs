use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Invalid condition or name in a mission
///
/// Conditions compare locations of specifications, fields of outputs and topics, `speed(…)`, `distance(…, …)` and
/// `state(…)` with values; `and`, `or` and `not` combine them. Each name must exist in the composite.
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
/// eventually = "Robot.moode = BUSY"
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
#[code(V032, error)]
#[error("{reason}")]
pub struct InvalidRunCondition {
    pub reason: String,
    pub at: Span,
    pub help: Option<String>,
}

impl Finding for InvalidRunCondition {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let diagnostic = diagnostic.label(self.at, "here");
        match &self.help {
            Some(help) => diagnostic.help(help.clone()),
            None => diagnostic,
        }
    }
}
