use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Blocks run each other too deep
///
/// `execblock` commands are nested through too many blocks. Run the blocks one after the other.
#[derive(Debug, thiserror::Error, Coded)]
#[code(V019, error)]
#[error("blocks nested deeper than {limit}")]
pub(crate) struct BlockCallsTooDeep {
    pub at: Span,
    pub limit: usize,
}

impl Finding for BlockCallsTooDeep {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "limit exceeded here")
            .help("run the blocks one after the other")
    }
}
