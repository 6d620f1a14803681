use crate::range::Range;
use crate::wording::label_or_outside;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Property value out of range
///
/// The type of a property limits its value. `min` and `max` can narrow the range further.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [properties]
/// period_ms = { type = "u32", default = 3, min = 5, max = 2000 }
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
/// period_ms = { type = "u32", default = 50, min = 5, max = 2000 }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C016, error)]
#[error("`{name}` must be in {range}, not {value}")]
pub(crate) struct SettingOutOfRange {
    pub name: String,
    pub value: String,
    pub range: Range,
    pub at: Option<Span>,
    pub declared: Option<Span>,
}

impl Finding for SettingOutOfRange {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            range,
            at,
            declared,
            ..
        } = self;
        let diagnostic = label_or_outside(diagnostic, *at, "out of range")
            .help(format!("write a value in {range}"));
        match declared {
            Some(declared) => diagnostic.label(*declared, "range declared here"),
            None => diagnostic,
        }
    }
}
