use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// A type described twice, and differently
///
/// Two files of types say different things about one type, and no message is both. Leave out one of them.
#[derive(Debug, thiserror::Error, Coded)]
#[code(C112, error)]
#[error("`{name}` is described twice, and differently: {difference}")]
pub(crate) struct ConflictingTypes {
    pub name: String,
    pub at: Span,
    pub first: Span,
    pub difference: String,
}

impl Finding for ConflictingTypes {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "described again here")
            .label(self.first, "described here")
            .help("leave one of the two out")
    }
}
