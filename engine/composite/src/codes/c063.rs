use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// No gateway
///
/// A service over HTTP is called through a gateway. If there are several, the promotion must name one.
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
/// binding = "http"
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
/// [gateways.main]
/// listen = "127.0.0.1:8080"
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// services = { maps = "nav/MapService" }
///
/// [[promote]]
/// service = "Map.maps"
/// as = "maps"
/// binding = "http"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C063, error)]
#[error("`http` needs a gateway, but this composite has {}", if *several { "several" } else { "none" })]
pub(crate) struct NoGateway {
    pub several: bool,
    pub at: Span,
}

impl Finding for NoGateway {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { several, .. } = self;
        diagnostic
            .label(self.at, "needs a gateway")
            .help(if *several {
                "select one with `gateway = \"main\"`"
            } else {
                "add `[gateways.main]` with `listen = \"127.0.0.1:8080\"`"
            })
    }
}
