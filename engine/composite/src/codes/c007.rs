use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Number out of range
///
/// Times, sizes and priorities have a minimum and a maximum.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// task = { period_ms = -5 }
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
/// task = { period_ms = 50 }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C007, error)]
#[error("`{key}` must be between {least} and {greatest}, not {value}")]
pub(crate) struct KeyOutOfRange {
    pub key: String,
    pub value: String,
    pub least: String,
    pub greatest: String,
    pub at: Span,
}

impl Finding for KeyOutOfRange {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            least, greatest, ..
        } = self;
        diagnostic
            .label(self.at, "out of range")
            .help(format!("write a number from {least} to {greatest}"))
    }
}
