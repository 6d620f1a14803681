use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Messages that go round between bridges
///
/// One bridge sends the messages of a connection to a topic of ROS, and another bridge brings them back: every message goes round for
/// ever. A single bridge that maps a topic in both directions suppresses its own messages.
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
/// [components.Sender]
/// implementation = { builtin = "ros-bridge", bridge = "ros" }
/// subscribe = { word = "std_msgs/String" }
/// map = [{ from = "word", ros = "/word", type = "std_msgs/String", direction = "to_ros" }]
///
/// [components.Receiver]
/// implementation = { builtin = "ros-bridge", bridge = "ros" }
/// publish = { word = "std_msgs/String" }
/// map = [{ from = "word", ros = "/word", type = "std_msgs/String", direction = "from_ros" }]
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
/// subscribe = { word = "std_msgs/String" }
/// publish = { word = "std_msgs/String" }
/// map = [
///   { from = "word", ros = "/word", type = "std_msgs/String", direction = "to_ros" },
///   { from = "word", ros = "/word", type = "std_msgs/String", direction = "from_ros" },
/// ]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C187, error)]
#[error("messages on `{topic}` go round for ever")]
pub(crate) struct EndlessCircle {
    pub topic: String,
    /// The mappings in their order, in words.
    pub way: String,
    pub at: Span,
    pub back: Span,
}

impl Finding for EndlessCircle {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "leave here")
            .label(self.back, "come back here")
            .note(self.way.clone())
            .help("map both directions in one ros-bridge, which suppresses its own messages, or use another topic for one of them")
    }
}
