use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Composites nested too deep
///
/// Composites can be nested only to a limited depth. Merge some of the files.
#[derive(Debug, thiserror::Error, Coded)]
#[code(C081, error)]
#[error("composites nested deeper than {MAX_DEPTH}")]
pub(crate) struct CompositesTooDeep {
    pub at: Span,
}

impl Finding for CompositesTooDeep {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "limit exceeded here")
            .help("merge some of them into one file")
    }
}

/// Maximum nesting depth of composites.
pub(crate) const MAX_DEPTH: usize = 32;
