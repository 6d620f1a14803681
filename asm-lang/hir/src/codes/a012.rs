use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Imports nested too deep
///
/// Imports may nest 64 files deep. A longer chain is usually a mistake; import the last module
/// directly.
#[derive(Debug, thiserror::Error, Coded)]
#[code(A012, error)]
#[error("imports nested deeper than {limit} files")]
pub(crate) struct ImportsTooDeep {
    pub at: Span,
    pub limit: usize,
}

impl Finding for ImportsTooDeep {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "limit exceeded here")
            .help("import the needed module directly")
    }
}
