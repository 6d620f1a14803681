use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Mission ended otherwise than expected
///
/// The end condition did not hold before the time limit, or a component failed that the mission does not list under
/// `may_fail`.
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
