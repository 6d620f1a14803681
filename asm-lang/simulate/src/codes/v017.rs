use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Scenario too long
///
/// Blocks that run other blocks multiply the number of commands. Run them less often.
#[derive(Debug, thiserror::Error, Coded)]
#[code(V017, error)]
#[error("scenario too long")]
pub(crate) struct ScenarioTooLong {
    pub at: Span,
    pub limit: usize,
}

impl Finding for ScenarioTooLong {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { limit, .. } = self;
        diagnostic
            .label(self.at, format!("more than {limit} commands from here on"))
            .help("run blocks less often")
    }
}
