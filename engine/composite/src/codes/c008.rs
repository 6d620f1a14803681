use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unsupported schema version
///
/// The `schema` key names the dialect and its version. The same key can mean something else in another
/// version, so the file is not read.
///
/// ```toml wrong
/// schema = "composite/2"
///
/// [composite]
/// name = "example"
/// ```
///
/// Corrected:
///
/// ```toml corrected
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C008, error)]
#[error("unsupported schema `{found}`")]
pub(crate) struct UnknownSchema {
    pub found: String,
    pub wanted: &'static str,
    pub at: Span,
}

impl Finding for UnknownSchema {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { wanted, .. } = self;
        diagnostic
            .label(self.at, "not supported by this version")
            .guess(
                format!("write `{wanted}`, the schema of this version"),
                self.at,
                *wanted,
            )
    }
}
