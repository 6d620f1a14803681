use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Not expressible in SCDL
///
/// SCDL has services, references and properties, but no ports, topics, bindings of specifications,
/// deadlines or processes. They are exported as comments.
///
/// ```toml wrong
/// schema = "composite/1"
/// [composite]
/// name = "example"
/// version = "1.0.0"
/// ```
///
/// Corrected:
///
/// ```toml corrected
/// schema = "composite/1"
/// [composite]
/// name = "example"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(X010, warning)]
#[error("SCDL cannot express {what} of `{of}`")]
pub(crate) struct NoScdlForm {
    pub what: String,
    pub of: String,
    pub at: Span,
}

impl Finding for NoScdlForm {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "omitted")
            .help("keep the composite file as the original")
    }
}
