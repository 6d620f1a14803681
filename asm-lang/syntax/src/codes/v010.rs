use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Blocks that nest too deep
///
/// Blocks stand in blocks some levels deep and no deeper. Most do not have to: `execblock` runs a block
/// from anywhere.
#[derive(Debug, thiserror::Error, Coded)]
#[code(V010, error)]
#[error("blocks nest too deep")]
pub(crate) struct BlocksNestTooDeep {
    pub at: Span,
}

impl Finding for BlocksNestTooDeep {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "one more begins here")
            .help("end blocks before others begin; `execblock` runs them anywhere")
    }
}
