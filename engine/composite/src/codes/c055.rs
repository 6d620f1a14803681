use asmotion_component::BusHealth;
use asmotion_component::HEALTH_TOPIC;
use asmotion_datum::Message;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Reserved topic
///
/// The engine publishes the state of the bus on the topic `bus`, as messages of type `bus/Health`. No
/// component may publish this topic or read it as another type.
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
/// Corrected:
///
/// ```toml corrected
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
/// To read the state of the bus, write `subscribe = { bus = "bus/Health" }`.
#[derive(Debug, thiserror::Error, Coded)]
#[code(C055, error)]
#[error("topic `{HEALTH_TOPIC}` is reserved for the state of the bus")]
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
                .help("rename the topic"),
            OwnProblem::Type(kind) => diagnostic
                .label(self.at, format!("`{kind}` here"))
                .help(format!("the messages have type `{}`", BusHealth::NAME)),
        }
    }
}

/// Invalid use of the reserved topic.
#[derive(Debug)]
pub(crate) enum OwnProblem {
    /// Published by a component.
    Published,
    /// Subscribed with this message type.
    Type(String),
}
