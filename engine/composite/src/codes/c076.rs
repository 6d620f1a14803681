use std::borrow::Cow;

use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Key not supported by this version
///
/// The key is valid, but this version ignores it: `[bridges]` of kinds that this build does not connect, operations of a ros-bridge that connects topics only, and how to start a program outside (`arguments`, `executable`, `name_service`).
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [bridges.old]
/// kind = "rosbridge"
/// url = "ws://127.0.0.1:9090"
///
/// [components.Bridge]
/// implementation = { builtin = "ros-bridge", bridge = "old" }
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
/// [bridges.old]
/// kind = "ros1"
/// master = "http://127.0.0.1:11311"
///
/// [components.Bridge]
/// implementation = { builtin = "ros-bridge", bridge = "old" }
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
#[code(C076, warning)]
#[error("`{key}` is not supported by this version")]
pub(crate) struct UnsupportedKey {
    pub key: &'static str,
    pub at: Span,
    /// Way out without the key.
    pub instead: Cow<'static, str>,
}

impl Finding for UnsupportedKey {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "has no effect")
            .help(self.instead.clone())
    }
}
