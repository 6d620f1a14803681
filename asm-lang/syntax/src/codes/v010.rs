use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Blocks nested too deep
///
/// Blocks may nest only to a limited depth. Use `execblock` to run a block from anywhere instead of
/// nesting it.
#[derive(Debug, thiserror::Error, Coded)]
#[code(V010, error)]
#[error("blocks nested too deep")]
pub(crate) struct BlocksNestTooDeep {
    pub at: Span,
}

impl Finding for BlocksNestTooDeep {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "limit exceeded here")
            .help("close blocks before opening others; run them with `execblock`")
    }
}
