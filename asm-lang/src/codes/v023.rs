use asmotion_diagnostics::{Coded, Diagnostic, Finding, LoadError};

/// A scenario that cannot be read
///
/// The path leads to no file that can be read.
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
