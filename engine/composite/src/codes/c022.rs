use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// No broker
///
/// A binding over AMQP needs a broker.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// services = { maps = "nav/MapService" }
///
/// [[promote]]
/// service = "Map.maps"
/// as = "maps"
/// binding = "amqp"
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
/// [brokers.main]
/// url = "amqp://guest:guest@localhost:5672"
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// services = { maps = "nav/MapService" }
///
/// [[promote]]
/// service = "Map.maps"
/// as = "maps"
/// binding = "amqp"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C022, error)]
#[error("`amqp` needs a broker, but {reason}")]
pub(crate) struct MissingBroker {
    pub at: Span,
    pub reason: &'static str,
}

impl Finding for MissingBroker {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "needs a broker")
            .help("add `[brokers.main]` with its `url`, and write `broker = \"main\"` here")
    }
}
