use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Output on two topics
///
/// The output is published on the topic of its own name and, by a connection, on another one. Use only
/// one of them.
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
            .label(self.at, "second topic")
            .label(self.first_at, "first topic")
            .help("remove one of them; a reader can use another name with `rename`")
    }
}
