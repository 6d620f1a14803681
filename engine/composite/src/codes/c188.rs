use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Value of a specification that a converter does not know
///
/// A converter of values names what each literal of the function is in ROS. A message with another literal is dropped, and counted
/// as a misfit of the bridge.
///
/// ```asm
/// asm example
/// signature:
///   enum domain Mode = {IDLE | MOVING | CHARGING}
///   out mode: Mode
/// definitions:
///   main rule r_Main = skip
/// ```
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
/// [components.Coordinator]
/// implementation = { asm = "example.asm" }
/// publish = { mode = "std_msgs/String" }
/// bind.out.mode = { topic = "mode", field = "data", publish = "on_update" }
///
/// [components.Bridge]
/// implementation = { builtin = "ros-bridge", bridge = "ros" }
/// subscribe = { mode = "std_msgs/String" }
/// map = [
///   { from = "mode", ros = "/mode", type = "std_msgs/String", direction = "to_ros", convert = { data = "IDLE = idle, MOVING = moving" } },
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
/// [components.Coordinator]
/// implementation = { asm = "example.asm" }
/// publish = { mode = "std_msgs/String" }
/// bind.out.mode = { topic = "mode", field = "data", publish = "on_update" }
///
/// [components.Bridge]
/// implementation = { builtin = "ros-bridge", bridge = "ros" }
/// subscribe = { mode = "std_msgs/String" }
/// map = [
///   { from = "mode", ros = "/mode", type = "std_msgs/String", direction = "to_ros", convert = { data = "IDLE = idle, MOVING = moving, CHARGING = charging" } },
/// ]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C188, warning)]
#[error("the converter lacks values of `{function}`: `{}`", literals.join("`, `"))]
pub(crate) struct UnconvertedLiteral {
    pub function: String,
    pub literals: Vec<String>,
    pub at: Span,
    pub declared: Span,
}

impl Finding for UnconvertedLiteral {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "messages with other values are dropped")
            .label(self.declared, "declared here")
            .help("add a pair for each of them")
    }
}
