use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Wrong type of value
///
/// Write numbers and Booleans without quotes, strings in quotes and tables in braces.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// task = { period_ms = "50" }
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
#[code(C005, error)]
#[error("mismatched types: expected {expected} for `{key}`, found {found}")]
pub(crate) struct WrongKeyType {
    pub key: String,
    pub expected: &'static str,
    pub found: &'static str,
    pub at: Span,
    /// Unit of a number; empty if none.
    pub unit: &'static str,
    pub example: String,
}

impl Finding for WrongKeyType {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            key,
            expected,
            example,
            unit,
            ..
        } = self;
        let diagnostic = diagnostic.label(self.at, format!("expected {expected}"));
        if example.starts_with("[[") {
            return diagnostic.help(format!("begin each table of the list with `{example}`"));
        }
        let value = match *unit {
            "" => "a value".to_owned(),
            unit => format!("a whole number of {unit}"),
        };
        diagnostic.help(format!("write {value} as in `{key} = {example}`"))
    }
}
