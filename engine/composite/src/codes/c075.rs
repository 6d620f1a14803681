use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// No broker between processes
///
/// Once a component names its broker with `task.broker`, components without one are reachable only
/// within their own process. Two processes communicate over a broker that both of them use.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [brokers.main]
/// url = "amqp://${ROBOT_USER}:${ROBOT_PASSWORD}@desk:5672/cell"
///
/// [components.Speaker]
/// implementation = { process = "speaker" }
/// task = { broker = "main" }
/// publish = { word = "std_msgs/String" }
///
/// [components.Hearer]
/// implementation = { process = "hearer" }
/// subscribe = { word = "std_msgs/String" }
///
/// [deploy]
/// processes = [
///   { name = "robot", components = ["Speaker"] },
///   { name = "desk", components = ["Hearer"] },
/// ]
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
/// [brokers.main]
/// url = "amqp://${ROBOT_USER}:${ROBOT_PASSWORD}@desk:5672/cell"
///
/// [components.Speaker]
/// implementation = { process = "speaker" }
/// task = { broker = "main" }
/// publish = { word = "std_msgs/String" }
///
/// [components.Hearer]
/// implementation = { process = "hearer" }
/// task = { broker = "main" }
/// subscribe = { word = "std_msgs/String" }
///
/// [deploy]
/// processes = [
///   { name = "robot", components = ["Speaker"] },
///   { name = "desk", components = ["Hearer"] },
/// ]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C075, error)]
#[error("{what} needs a broker between process `{}` and `{}`", processes.0, processes.1)]
pub(crate) struct NoCommonBroker {
    /// Topic or wire, such as `topic scan` or `the wire from A.x to B.y`.
    pub what: String,
    pub processes: (String, String),
    /// Reason: the component without a broker, or the differing brokers.
    pub why: String,
    pub at: Span,
}

impl Finding for NoCommonBroker {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, self.why.clone())
            .help("name a broker for both with `task.broker`, or place them in one process")
    }
}
