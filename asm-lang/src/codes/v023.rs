use asmotion_diagnostics::{Coded, Diagnostic, Finding, LoadError};

/// Unreadable scenario
///
/// The path is not a readable file.
#[derive(Debug, thiserror::Error, Coded)]
#[code(V023, error)]
#[error("{error}")]
pub(crate) struct UnreadableScenario {
    pub error: LoadError,
}

impl Finding for UnreadableScenario {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic.help("check the path of the scenario")
    }
}
