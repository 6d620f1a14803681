use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Invalid TOML
///
/// A composite file is TOML. Close every bracket and quote, and write each key and each `[table]` once.
/// Text after the reported place is not checked.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer"
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
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C001, error)]
#[error("invalid TOML: {message}")]
pub(crate) struct InvalidToml {
    pub message: String,
    pub at: Span,
    pub earlier: Option<Span>,
}

impl Finding for InvalidToml {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { earlier, .. } = self;
        let diagnostic = diagnostic.label(self.at, "found here");
        match earlier {
            Some(earlier) => diagnostic
                .label(*earlier, "first defined here")
                .help("rename the second one, or merge the two"),
            None => diagnostic,
        }
    }
}
