use crate::wording::has;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Listed input does not exist
///
/// The component has no such input, so messages sent to it are lost.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// subscribe = { weather = "std_msgs/String" }
///
/// [[promote]]
/// topic = "weather"
/// as = "weather"
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
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C029, warning)]
#[error("unknown input `{name}` of `{implementation}`")]
pub(crate) struct SubscriptionNeverRead {
    pub implementation: String,
    pub name: String,
    pub at: Span,
    pub made_of: Span,
    pub known: Vec<String>,
}

impl Finding for SubscriptionNeverRead {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "messages to it are lost")
            .label(self.made_of, "component implemented here")
            .help(has("input", self.known.iter().map(String::as_str)))
    }
}
