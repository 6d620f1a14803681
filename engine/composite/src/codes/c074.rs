use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Local wire between processes
///
/// A wire with `binding = "local"` works only within a process, but its reference and its service are
/// in different processes.
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
/// [components.User]
/// implementation = { process = "user" }
/// references = { maps = "nav/MapService" }
///
/// [[wires]]
/// reference = "User.maps"
/// service = "Map.maps"
/// binding = "local"
/// timeout_ms = 1000
///
/// [deploy]
/// processes = [
///   { name = "robot", components = ["Map"] },
///   { name = "desk", components = ["User"] },
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
/// [components.User]
/// implementation = { process = "user" }
/// references = { maps = "nav/MapService" }
///
/// [[wires]]
/// reference = "User.maps"
/// service = "Map.maps"
/// timeout_ms = 1000
///
/// [deploy]
/// processes = [
///   { name = "robot", components = ["Map"] },
///   { name = "desk", components = ["User"] },
/// ]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C074, error)]
#[error("`{from}` in process `{}` and `{to}` in `{}` cannot use a local wire", processes.0, processes.1)]
pub(crate) struct LocalWireAcross {
    pub from: String,
    pub to: String,
    pub processes: (String, String),
    pub at: Span,
}

impl Finding for LocalWireAcross {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "works only within a process")
            .help("place both components in one process, or remove `binding`")
    }
}
