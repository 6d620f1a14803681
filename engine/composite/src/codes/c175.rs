use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Wrong definition of ROS
///
/// The key `definitions` of a bridge names folders with files `PACKAGE/msg/NAME.msg`, `PACKAGE/srv/NAME.srv` and
/// `PACKAGE/action/NAME.action`: a package, a folder with packages, or an installed ROS such as `/opt/ros/jazzy/share`. The folder
/// cannot be read, has no such file, or a file is not a definition of the generation of ROS that the bridge connects to.
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
/// definitions = ["no_such_folder"]
///
/// [components.Bridge]
/// implementation = { builtin = "ros-bridge", bridge = "ros" }
/// subscribe = { plan = "nav_msgs/Path" }
/// map = [
///   { from = "plan", ros = "/trajectory", type = "nav_msgs/Path", direction = "to_ros" },
/// ]
///
/// [[promote]]
/// topic = "plan"
/// as = "plan"
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
/// subscribe = { plan = "nav_msgs/Path" }
/// map = [
///   { from = "plan", ros = "/trajectory", type = "nav_msgs/Path", direction = "to_ros" },
/// ]
///
/// [[promote]]
/// topic = "plan"
/// as = "plan"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C175, error)]
#[error("wrong definition of ROS: {reason}")]
pub(crate) struct WrongRosDefinition {
    pub reason: String,
    /// Folder as the composite names it.
    pub folder: String,
    pub at: Span,
    /// The line of the definition; `None` if the folder itself is the problem.
    pub line: Option<Span>,
}

impl Finding for WrongRosDefinition {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        match self.line {
            Some(line) => diagnostic
                .label(line, "in this definition")
                .label(self.at, "read because this folder is named here"),
            None => diagnostic
                .label(self.at, "named here")
                .help(format!(
                    "a folder has files such as `{}/PACKAGE/msg/NAME.msg`, and is relative to the composite",
                    self.folder
                )),
        }
    }
}
