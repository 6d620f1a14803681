use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Type differs from the build
///
/// The build already has this type with other fields, so messages of the two would be incompatible.
///
/// ```toml wrong
/// schema = "composite-types/1"
///
/// [type."nav/Event"]
/// fields = { code = "f64" }
/// ```
///
/// Corrected:
///
/// ```toml corrected
/// schema = "composite-types/1"
///
/// [type."arm/Event"]
/// fields = { code = "f64" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C113, error)]
#[error("description of `{name}` differs from this build: {difference}")]
pub(crate) struct TypeDiffersFromBuild {
    pub name: String,
    pub at: Span,
    pub difference: String,
}

impl Finding for TypeDiffersFromBuild {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "described here")
            .help("remove the description; the build knows the type")
    }
}
