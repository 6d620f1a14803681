use crate::nearest::Nearest;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Topic without a publisher
///
/// No component publishes this topic, and the composite does not promote it. Its subscribers would
/// never receive a message.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Follower]
/// implementation = { process = "follower" }
/// subscribe = { path = "nav_msgs/Path" }
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
/// [components.Follower]
/// implementation = { process = "follower" }
/// subscribe = { path = "nav_msgs/Path" }
///
/// [[promote]]
/// topic = "path"
/// as = "path"
/// ```
///
/// In this example the topic is published from outside, so the composite promotes it. Within a
/// composite, a component publishes a topic with `publish`.
#[derive(Debug, thiserror::Error, Coded)]
#[code(C051, warning)]
#[error("no component publishes `{topic}`")]
pub(crate) struct SilentTopic {
    pub topic: String,
    pub at: Span,
    pub written: Written,
    pub nearest: Option<Nearest>,
}

impl Finding for SilentTopic {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            topic,
            written,
            nearest,
            ..
        } = self;
        let diagnostic = diagnostic.label(self.at, "subscribed here");
        let Some(Nearest { name, declared }) = nearest else {
            return diagnostic.help(format!(
                "to receive it from outside, add `[[promote]]` with `topic = \"{topic}\"` and `as = \"{topic}\"`"
            ));
        };
        let diagnostic = match declared {
            Some(declared) => diagnostic.label(*declared, format!("`{name}` is published here")),
            None => diagnostic,
        };
        match written {
            Written::At(span) => diagnostic.did_you_mean(*span, Some(name)),
            Written::AsPort(port) => diagnostic.help(format!(
                "did you mean `rename = {{ {port} = \"{name}\" }}`?"
            )),
        }
    }
}

/// Origin of a topic name.
#[derive(Clone, Debug)]
pub(crate) enum Written {
    /// Written explicitly at this location, where a suggestion can replace it.
    At(Span),
    /// Derived from the name of a port.
    AsPort(String),
}
