use crate::nearest::Nearest;
use crate::nearest::Suggest;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Settings of an unknown topic
///
/// `[topics.NAME]` configures how a topic is sent over a broker. No port of the composite uses a topic
/// of this name. The reserved topic `bus` is not sent over a broker.
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
/// Corrected:
///
/// ```toml corrected
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
#[error("unknown topic `{topic}`")]
pub(crate) struct UnknownTopicSettings {
    pub topic: String,
    pub at: Span,
    pub nearest: Option<Nearest>,
}

impl Finding for UnknownTopicSettings {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { nearest, .. } = self;
        diagnostic.label(self.at, "not used by a port").suggest_or(
            self.at,
            nearest,
            "configure a topic that a port publishes or subscribes",
        )
    }
}
