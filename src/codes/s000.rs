use asmotion_diagnostics::{Coded, Diagnostic, Finding, LoadError};

/// Unreadable script or trace
///
/// The path given with `--env` or `--replay-inputs` is not a readable file.
#[derive(Debug, thiserror::Error, Coded)]
#[code(S000, error)]
#[error("{error}")]
pub struct UnreadableScript {
    pub error: LoadError,
    /// Description of the argument, for example "the path of the script".
    pub named: String,
}

impl Finding for UnreadableScript {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic.help(format!("check {}", self.named))
    }
}
