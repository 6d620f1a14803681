use asmotion_component::BusHealth;
use asmotion_component::HEALTH_TOPIC;
use asmotion_datum::Message;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// The engine's own topic
///
/// On the topic `bus` the engine tells every component how the bus is, in messages of type `bus/Health`. Nobody else
/// publishes it, and nobody reads it as something else.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Shuttle]
/// implementation = { process = "shuttle" }
/// publish = { bus = "std_msgs/String" }
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
/// [components.Shuttle]
/// implementation = { process = "shuttle" }
/// publish = { bus = "std_msgs/String" }
/// rename = { bus = "shuttle" }
/// ```
///
/// Who wants to know how the bus is writes `subscribe = { bus = "bus/Health" }`.
#[derive(Debug, thiserror::Error, Coded)]
#[code(C055, error)]
#[error("topic `{HEALTH_TOPIC}` is the engine's own: it tells there how its bus is")]
pub(crate) struct EngineTopic {
    pub at: Span,
    pub problem: OwnProblem,
}

impl Finding for EngineTopic {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { problem, .. } = self;
        match problem {
            OwnProblem::Published => diagnostic
                .label(self.at, "published here")
                .help("publish on another topic: rename it"),
            OwnProblem::Type(kind) => diagnostic
                .label(self.at, format!("`{kind}` here"))
                .help(format!("its messages are of type `{}`", BusHealth::NAME)),
        }
    }
}

/// What is wrong with a use of the engine's own topic.
#[derive(Debug)]
pub(crate) enum OwnProblem {
    /// Somebody else publishes it.
    Published,
    /// Somebody reads it as messages of this type.
    Type(String),
}
