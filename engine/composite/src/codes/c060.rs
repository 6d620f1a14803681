use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Duplicate promoted name
///
/// Promoted services share one set of names outside the composite, and so do topics.
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
///
/// [[promote]]
/// service = "Map.maps"
/// as = "maps"
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
/// [[promote]]
/// service = "Map.maps"
/// as = "maps"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C060, error)]
#[error("duplicate promoted {what} `{name}`")]
pub(crate) struct DuplicatePromotion {
    pub what: &'static str,
    pub name: String,
    pub at: Span,
    pub first: Span,
}

impl Finding for DuplicatePromotion {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "promoted again here")
            .label(self.first, "first promoted here")
            .help(match self.what {
                "service" => {
                    "rename one of them with `as`, or list all bindings in one promotion: `binding = [\"amqp\", \"http\"]`"
                }
                _ => "rename one of them with `as`",
            })
    }
}
