use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Substitution not allowed here
///
/// Implementations are fixed when the composite is checked, so they are written out. Substitution works
/// in property values, in times and in endpoints.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [properties]
/// server = { type = "string", default = "nav::MapServer" }
///
/// [components.Map]
/// implementation = { rust = "${properties.server}" }
/// ```
///
/// Corrected:
///
/// ```toml corrected
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [properties]
/// folder = { type = "string", default = "maps" }
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// properties = { source = "${properties.folder}" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C011, error)]
#[error("substitution is not allowed in `{key}`")]
pub(crate) struct SubstitutionNotAllowed {
    pub key: String,
    pub at: Span,
}

impl Finding for SubstitutionNotAllowed {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "not substituted")
            .help("substitution works in values of properties, in times and in endpoints")
    }
}
