use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Gateway in two processes
///
/// A gateway runs in the process of the services that are called through it. Two processes cannot
/// listen at the same address.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [gateways.main]
/// listen = "127.0.0.1:8080"
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// services = { maps = "nav/MapService" }
///
/// [components.Archive]
/// implementation = { rust = "nav::MapServer" }
/// services = { maps = "nav/MapService" }
///
/// [[promote]]
/// service = "Map.maps"
/// as = "maps"
/// binding = "http"
///
/// [[promote]]
/// service = "Archive.maps"
/// as = "archive"
/// binding = "http"
///
/// [deploy]
/// processes = [
///   { name = "onboard", components = ["Map"] },
///   { name = "supervisor", components = ["Archive"] },
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
/// [gateways.onboard]
/// listen = "127.0.0.1:8080"
///
/// [gateways.supervisor]
/// listen = "127.0.0.1:8081"
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// services = { maps = "nav/MapService" }
///
/// [components.Archive]
/// implementation = { rust = "nav::MapServer" }
/// services = { maps = "nav/MapService" }
///
/// [[promote]]
/// service = "Map.maps"
/// as = "maps"
/// binding = "http"
/// gateway = "onboard"
///
/// [[promote]]
/// service = "Archive.maps"
/// as = "archive"
/// binding = "http"
/// gateway = "supervisor"
///
/// [deploy]
/// processes = [
///   { name = "onboard", components = ["Map"] },
///   { name = "supervisor", components = ["Archive"] },
/// ]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C066, error)]
#[error("gateway `{gateway}` is used in process `{}` and in `{}`", processes.0, processes.1)]
pub(crate) struct GatewayInTwoProcesses {
    pub gateway: String,
    pub processes: (String, String),
    pub at: Span,
    pub first: Span,
}

impl Finding for GatewayInTwoProcesses {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(
                self.at,
                format!("component in process `{}`", self.processes.1),
            )
            .label(
                self.first,
                format!("component in process `{}`", self.processes.0),
            )
            .help("add a gateway for each process, and select it with `gateway`")
    }
}
