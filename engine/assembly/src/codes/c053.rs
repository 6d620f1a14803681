use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// An output on two topics
///
/// An output goes to the topic of its name, and to another one by a connection: say which is meant.
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
/// from = "Laser.scan"
/// to = "topic:laser"
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
/// [components.Laser]
/// implementation = { process = "laser" }
/// publish = { scan = "sensor_msgs/LaserScan" }
/// rename = { scan = "laser" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C053, error)]
#[error("output `{port}` is on two topics: `{first}` and `{second}`")]
pub(crate) struct OutputOnTwoTopics {
    pub port: String,
    pub first: String,
    pub first_at: Span,
    pub second: String,
    pub at: Span,
}

impl Finding for OutputOnTwoTopics {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "the second topic")
            .label(self.first_at, "the first topic")
            .help("an output writes one topic; whoever wants another name renames it")
    }
}
