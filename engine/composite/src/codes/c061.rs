use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use asmotion_mqueue::UnsupportedTypeError;

/// Type not supported by message queues
///
/// A queue `mqueue:/name` connects to an Orocos component and carries what RTT can encode: numbers,
/// Booleans, arrays, lists, and messages made of them. Strings are not supported: RTT would write a
/// pointer.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Talker]
/// implementation = { process = "talker" }
/// ports.out = { words = "std_msgs/String" }
///
/// [[connections]]
/// from = "Talker.words"
/// to = "mqueue:/words"
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
/// [components.Joystick]
/// implementation = { process = "joystick" }
/// ports.out = { twist = "geometry_msgs/Twist" }
///
/// [[connections]]
/// from = "Joystick.twist"
/// to = "mqueue:/twist"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C061, error)]
#[error("`{kind}` cannot be sent over `mqueue:{queue}`: {reason}")]
pub(crate) struct NoMqueueLayout {
    pub kind: String,
    pub queue: String,
    pub reason: UnsupportedTypeError,
    pub at: Span,
}

impl Finding for NoMqueueLayout {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "not supported by Orocos")
            .help(
                "send numbers, Booleans, and arrays, lists and records of them; a component in between can drop the rest",
            )
    }
}
