use crate::nearest::Nearest;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// A topic that nobody publishes
///
/// Nobody in the composite publishes it, and it is not promoted to the outside: the reader waits for ever.
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
/// Mended:
///
/// ```toml mended
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
/// Here somebody outside publishes it. Within one composite, a component does so by `publish`.
#[derive(Debug, thiserror::Error, Coded)]
#[code(C051, warning)]
#[error("nobody publishes `{topic}`")]
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
                "if it comes from outside, write `[[promote]]` with `topic = \"{topic}\"`"
            ));
        };
        let diagnostic = match declared {
            Some(declared) => diagnostic.label(*declared, format!("`{name}` is published here")),
            None => diagnostic,
        };
        match written {
            Written::At(span) => diagnostic.guess(format!("did you mean `{name}`?"), *span, name),
            Written::AsPort(port) => diagnostic.help(format!(
                "did you mean `rename = {{ {port} = \"{name}\" }}`?"
            )),
        }
    }
}

/// How the topic's name came about.
#[derive(Clone, Debug)]
pub(crate) enum Written {
    /// It stands at a place, where it can be replaced.
    At(Span),
    /// It is the name of the port.
    AsPort(String),
}
