use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Recursive message type
///
/// A message cannot contain a message of its own type: it would never end.
///
/// ```toml wrong
/// schema = "composite-types/1"
///
/// [type."arm/Tree"]
/// fields = { name = "string", left = "arm/Tree" }
/// ```
///
/// Corrected:
///
/// ```toml corrected
/// schema = "composite-types/1"
///
/// [type."arm/Tree"]
/// fields = { name = "string", left = "string" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C111, error)]
#[error("recursive type `{name}`")]
pub(crate) struct RecursiveType {
    pub name: String,
    pub at: Span,
}

impl Finding for RecursiveType {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "makes every message infinite")
            .help("refer to the inner one by a number or a string")
    }
}
