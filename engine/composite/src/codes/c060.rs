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
/// Mended:
///
/// ```toml mended
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
#[error("two things are promoted as {what} `{name}`")]
pub(crate) struct DuplicatePromotion {
    pub what: &'static str,
    pub name: String,
    pub at: Span,
    pub first: Span,
}

impl Finding for DuplicatePromotion {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "again here")
            .label(self.first, "first here")
            .help(match self.what {
                "service" => {
                    "give one of them another name with `as`, or list all it goes over in one: \
                         `binding = [\"amqp\", \"http\"]`"
                }
                _ => "give one of them another name with `as`",
            })
    }
}
