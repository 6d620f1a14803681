use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// A scenario that becomes too long
///
/// Blocks that run blocks that run blocks make more commands than anyone wants to wait for. Let them
/// run each other less often.
#[derive(Debug, thiserror::Error, Coded)]
#[code(V017, error)]
#[error("the scenario becomes too long")]
pub(crate) struct ScenarioTooLong {
    pub at: Span,
    pub limit: usize,
}

impl Finding for ScenarioTooLong {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { limit, .. } = self;
        diagnostic
            .label(
                self.at,
                format!("it has more than {limit} commands from here on"),
            )
            .help("let blocks run each other less often")
    }
}
