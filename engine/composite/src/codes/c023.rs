use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Duplicate component id
///
/// The id identifies a component in messages, in traces and on the broker. It is the `id` of the
/// component's task, or its name by default.
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
/// [components.Spare]
/// implementation = { rust = "nav::MapServer" }
/// task = { id = "Map", period_ms = 50 }
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
///
/// [components.Spare]
/// implementation = { rust = "nav::MapServer" }
/// task = { id = "Spare", period_ms = 50 }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C023, error)]
#[error("duplicate component id `{id}`")]
pub(crate) struct DuplicateId {
    pub id: String,
    pub at: Span,
    pub first: Span,
}

impl Finding for DuplicateId {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
                .label(self.at, "used again here")
                .label(self.first, "first used here")
                .help("change one `task.id` (default: the component's name); it names the component's queue, log and metrics")
    }
}
