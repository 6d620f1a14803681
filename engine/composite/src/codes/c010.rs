use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Mutually exclusive keys
///
/// A component has one implementation, and one table that schedules it: `task` if it is reached over a
/// broker, otherwise `activity`.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// task = { period_ms = 50 }
/// activity = { period_ms = 50 }
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
/// activity = { period_ms = 50 }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C010, error)]
#[error("`{second}` cannot be combined with `{first}`")]
pub(crate) struct ExclusiveKeys {
    pub first: String,
    pub first_at: Span,
    pub second: String,
    pub at: Span,
    pub reason: &'static str,
}

impl Finding for ExclusiveKeys {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { first, .. } = self;
        diagnostic
            .label(self.at, self.reason)
            .label(self.first_at, format!("`{first}` is set here"))
    }
}
