use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Missing key
///
/// This key is required and has no default. The message shows an example.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Map]
/// services = { maps = "nav/MapService" }
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
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// services = { maps = "nav/MapService" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C004, error)]
#[error("missing key `{key}` in {of}")]
pub(crate) struct MissingKey {
    pub key: &'static str,
    pub of: &'static str,
    pub at: Span,
    pub example: String,
}

impl Finding for MissingKey {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { key, example, .. } = self;
        diagnostic
            .label(self.at, format!("expected `{key}`"))
            .help(format!("add it, as in `{key} = {example}`"))
    }
}
