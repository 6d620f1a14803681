use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Connection without a component
///
/// A topic is not a component, so nothing would carry messages from one topic to the other.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Laser]
/// implementation = { process = "laser" }
/// publish = { scan = "sensor_msgs/LaserScan" }
///
/// [[connections]]
/// from = "topic:scan"
/// to = "topic:laser"
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
/// [components.Laser]
/// implementation = { process = "laser" }
/// publish = { scan = "sensor_msgs/LaserScan" }
/// rename = { scan = "laser" }
/// ```
///
/// `rename` puts the output on the other topic.
#[derive(Debug, thiserror::Error, Coded)]
#[code(C041, error)]
#[error("connection from {from} to {to} without a component")]
pub(crate) struct NoComponentJoined {
    pub from: &'static str,
    pub from_at: Span,
    pub to: &'static str,
    pub to_at: Span,
}

impl Finding for NoComponentJoined {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { from, to, .. } = self;
        diagnostic
            .label(self.to_at, *to)
            .label(
                self.from_at,
                format!("{from}{}", if from == to { ", too" } else { "" }),
            )
            .help(match (*from, *to) {
                ("a topic", "a topic") => "rename the topic where it is published or subscribed",
                _ => "connect a component in between, or connect the port itself to the message queue",
            })
    }
}
