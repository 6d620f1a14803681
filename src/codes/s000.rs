use asmotion_diagnostics::{Coded, Diagnostic, Finding, LoadError};

/// A script or trace that cannot be read
///
/// The path given with `--env` or `--replay-inputs` leads to no file that can be read.
#[derive(Debug, thiserror::Error, Coded)]
#[code(S000, error)]
#[error("{error}")]
pub struct UnreadableScript {
    pub error: LoadError,
    /// How the script was named: "the path of the script".
    pub named: String,
}

impl Finding for UnreadableScript {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic.help(format!("check {}", self.named))
    }
}
