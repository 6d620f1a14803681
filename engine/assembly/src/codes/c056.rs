use crate::nearest::Nearest;
use crate::nearest::Suggest;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// A topic that nothing is on
///
/// `[topics.NAME]` says how a topic goes over a broker, and no port of the composite is on a topic of this name. The
/// engine's own topic `bus` goes over none.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Planner]
/// implementation = { process = "planner" }
/// publish = { path = "nav_msgs/Path" }
///
/// [topics.paht]
/// confirm = true
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
/// [components.Planner]
/// implementation = { process = "planner" }
/// publish = { path = "nav_msgs/Path" }
///
/// [topics.path]
/// confirm = true
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C056, error)]
#[error("nothing is on topic `{topic}`")]
pub(crate) struct UnknownTopicSettings {
    pub topic: String,
    pub at: Span,
    pub nearest: Option<Nearest>,
}

impl Finding for UnknownTopicSettings {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { nearest, .. } = self;
        diagnostic.label(self.at, "no such topic").suggest_or(
            self.at,
            nearest,
            "here stands how a topic goes over a broker",
        )
    }
}
