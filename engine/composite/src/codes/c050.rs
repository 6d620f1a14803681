use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Topic with two types
///
/// All publishers and subscribers of a topic must use the same message type.
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
/// [components.Lidar]
/// implementation = { process = "lidar" }
/// publish = { scan = "nav_msgs/Path" }
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
///
/// [components.Lidar]
/// implementation = { process = "lidar" }
/// publish = { scan = "nav_msgs/Path" }
/// rename = { scan = "lidar" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C050, error)]
#[error("mismatched types: topic `{topic}` is `{kind}` and `{other}`")]
pub(crate) struct TopicWithTwoTypes {
    pub topic: String,
    pub kind: String,
    pub other: String,
    pub at: Span,
    pub other_at: Span,
}

impl Finding for TopicWithTwoTypes {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { kind, other, .. } = self;
        diagnostic
            .label(self.at, format!("`{kind}` here"))
            .label(self.other_at, format!("`{other}` here"))
            .help("use one type, or rename one of the topics")
    }
}
