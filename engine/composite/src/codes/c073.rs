use crate::nearest::Nearest;
use crate::nearest::Suggest;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Recorded topic does not exist
///
/// No component publishes this topic, so nothing would be recorded.
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
/// [deploy]
/// processes = [{ name = "robot", components = ["Laser"] }]
/// record = { topics = ["scam"] }
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
/// [deploy]
/// processes = [{ name = "robot", components = ["Laser"] }]
/// record = { topics = ["scan"] }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C073, warning)]
#[error("no topic matches `{topic}`")]
pub(crate) struct UnknownRecordedTopic {
    pub topic: String,
    pub at: Span,
    pub nearest: Option<Nearest>,
}

impl Finding for UnknownRecordedTopic {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { nearest, .. } = self;
        diagnostic
            .label(self.at, "records nothing")
            .suggest(self.at, nearest)
    }
}
