use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Component in two processes
///
/// A component runs in exactly one process.
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
/// [deploy]
/// processes = [
///   { name = "robot", components = ["Map"] },
///   { name = "station", components = ["Map"] },
/// ]
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
/// [deploy]
/// processes = [
///   { name = "robot", components = ["Map"] },
/// ]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C070, error)]
#[error("`{component}` is placed in two processes")]
pub(crate) struct PlacedTwice {
    pub component: String,
    pub at: Span,
    pub first: Span,
}

impl Finding for PlacedTwice {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "placed again here")
            .label(self.first, "first placed here")
            .help("remove it from one of them")
    }
}
