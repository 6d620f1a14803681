use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Conflicting type descriptions
///
/// Two type files describe the same type differently. Remove one of the descriptions.
#[derive(Debug, thiserror::Error, Coded)]
#[code(C112, error)]
#[error("conflicting descriptions of `{name}`: {difference}")]
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
            .label(self.first, "first described here")
            .help("remove one of them")
    }
}
