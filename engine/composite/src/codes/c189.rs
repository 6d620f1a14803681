use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Timeout shorter than the period of the provider
///
/// A periodic component answers requests in its cycles. If the timeout of a wire is shorter than the period of the provider, a
/// call is answered only if a cycle of the provider happens to begin in time.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// task = { period_ms = 1000 }
/// services = { maps = "nav/MapService" }
///
/// [components.User]
/// implementation = { process = "user" }
/// references = { maps = "nav/MapService" }
///
/// [[wires]]
/// reference = "User.maps"
/// service = "Map.maps"
/// timeout_ms = 800
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
/// task = { period_ms = 1000 }
/// services = { maps = "nav/MapService" }
///
/// [components.User]
/// implementation = { process = "user" }
/// references = { maps = "nav/MapService" }
///
/// [[wires]]
/// reference = "User.maps"
/// service = "Map.maps"
/// timeout_ms = 2500
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C189, warning)]
#[error(
    "calls of `{reference}` time out after {timeout_ms} ms, and `{provider}` answers every {period_ms} ms"
)]
pub(crate) struct TimeoutWithinPeriod {
    pub reference: String,
    pub timeout_ms: u64,
    /// Component that provides the service.
    pub provider: String,
    pub period_ms: u64,
    pub at: Span,
    pub period_at: Span,
}

impl Finding for TimeoutWithinPeriod {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let longer = self.period_ms.saturating_mul(2);
        diagnostic
            .label(self.at, "shorter than the period of the provider")
            .label(self.period_at, "the period")
            .help(format!(
                "allow at least one period and the time of the answer, `timeout_ms = {longer}`, or leave out `period_ms` so that \
                 requests start a cycle"
            ))
    }
}
