use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Mapped operation of another type
///
/// The argument of an operation becomes the request of the service, or the goal of the action: every field of the argument needs a
/// field with its name there, or the only field that takes it. The response or result becomes the result of the operation, of which
/// every field must be filled. From ROS to a component it is the other way round. An interface with the name of a
/// service or an action of ROS has the operation `call` with its types, and an action also `cancel`.
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
/// services = { maps = "nav/MapService" }
/// map = [
///   { from = "maps.getMap", ros = "/static_map", type = "nav_msgs/GetMap", direction = "to_ros" },
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
/// services = { maps = "nav_msgs/GetMap" }
/// map = [
///   { from = "maps.call", ros = "/static_map", type = "nav_msgs/GetMap", direction = "to_ros" },
/// ]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C181, error)]
#[error("the {part} of `{operation}` does not fit `{there}` of ROS")]
pub(crate) struct RosOperationDiffers {
    /// Request, response or feedback.
    pub part: &'static str,
    pub operation: String,
    pub there: String,
    pub at: Span,
    pub definition_here: String,
    pub definition_there: String,
}

impl Finding for RosOperationDiffers {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            part,
            operation,
            there,
            definition_here,
            definition_there,
            ..
        } = self;
        diagnostic
            .label(self.at, "type there")
            .note(format!("`{operation}` here:\n{}", definition_here.trim_end()))
            .note(format!("`{there}` there:\n{}", definition_there.trim_end()))
            .help(match *part {
                "feedback" => "give the port a type with the fields of the feedback".to_owned(),
                _ => format!(
                    "use the interface `{there}`, whose operation is `call`, or one with the same fields"
                ),
            })
    }
}
