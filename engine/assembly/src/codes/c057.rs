use asmotion_datum::DatumError;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// A topic that CDR cannot carry
///
/// CDR, as ROS 2 writes messages, does not say what it is: writer and reader follow the type. So the type must be known
/// down to the last field, and an array must have elements. Describe the type in a file of types, or let the topic go in
/// another way. What may be absent, and messages without fields, go as ROS 2 has them.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Joystick]
/// implementation = { process = "joystick" }
/// publish = { twist = "acme/Stick" }
///
/// [topics.twist]
/// codec = "cdr"
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
/// publish = { twist = "geometry_msgs/Twist" }
///
/// [topics.twist]
/// codec = "cdr"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C057, error)]
#[error("{what}: {reason}")]
pub(crate) struct Uncarried {
    /// What goes over the broker: "topic `scan`".
    pub what: String,
    /// Where another codec can be said of it.
    pub place: String,
    pub reason: DatumError,
    pub codec: Span,
    pub at: Span,
}

impl Finding for Uncarried {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let place = &self.place;
        diagnostic
            .label(self.at, "its messages are of this type")
            .label(self.codec, "CDR is wanted here")
            .help(format!(
                "describe the type, or send it otherwise: `codec = \"cbor\"` under `[{place}]`"
            ))
    }
}
