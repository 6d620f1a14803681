use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use asmotion_transform::{MessageTransform, NotTransformable};

/// Messages that cannot be transformed into another frame
///
/// The key `transform` is for messages with a header whose data are positions, poses or directions in the frame of the header. A twist
/// is not among them, because its frame does not say at which point it is taken, nor a laser scan, whose beams begin at the sensor.
/// Names of frames do not begin with a slash.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [bridges.ros]
/// kind = "ros1"
/// master = "http://127.0.0.1:11311"
///
/// [components.Bridge]
/// implementation = { builtin = "ros-bridge", bridge = "ros" }
/// publish = { word = "std_msgs/String" }
/// map = [
///   { from = "word", ros = "/word", type = "std_msgs/String", direction = "from_ros", transform = { frame = "map" } },
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
/// [bridges.ros]
/// kind = "ros1"
/// master = "http://127.0.0.1:11311"
///
/// [components.Bridge]
/// implementation = { builtin = "ros-bridge", bridge = "ros" }
/// publish = { plan = "nav_msgs/Path" }
/// map = [
///   { from = "plan", ros = "/plan", type = "nav_msgs/Path", direction = "from_ros", transform = { frame = "map" } },
/// ]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C174, error)]
#[error("{reason}")]
pub(crate) struct NoTransformation {
    pub reason: NotTransformable,
    pub at: Span,
}

impl Finding for NoTransformation {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let help = match &self.reason {
            NotTransformable::Type { .. } => {
                let types = MessageTransform::types().map(|it| format!("`{it}`"));
                format!(
                    "messages with a frame are {}",
                    types.collect::<Vec<_>>().join(", ")
                )
            }
            NotTransformable::Frame { .. } => {
                "write the name as in `/tf`, without a slash, as in `map`".to_owned()
            }
        };
        diagnostic
            .label(self.at, "messages are to be transformed into this frame")
            .help(help)
    }
}
