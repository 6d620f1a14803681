use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use asmotion_mqueue::LayoutError;

/// A type that no message queue carries
///
/// A queue `mqueue:/name` leads to an Orocos component, and carries what RTT writes there: numbers, truth values, arrays,
/// lists, and messages of them. A text has no form: RTT writes a pointer in its place.
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
/// Mended:
///
/// ```toml mended
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
#[error("`{kind}` cannot pass through `mqueue:{queue}`: {reason}")]
pub(crate) struct NoMqueueLayout {
    pub kind: String,
    pub queue: String,
    pub reason: LayoutError,
    pub at: Span,
}

impl Finding for NoMqueueLayout {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "Orocos writes no such type")
            .help(
                "numbers, truth values, arrays, lists and records of them have one: put a \
                     component between that leaves the rest out",
            )
    }
}
