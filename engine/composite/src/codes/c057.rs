use asmotion_datum::DatumError;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Type not representable in CDR
///
/// A CDR message, as used by ROS 2, does not describe itself: writer and reader must know its type down
/// to the last field, and arrays must have elements. Describe the type in a type file, or send the
/// topic with another codec. Optional values and empty messages are encoded as in ROS 2.
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
/// publish = { twist = "geometry_msgs/Twist" }
///
/// [topics.twist]
/// codec = "cdr"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C057, error)]
#[error("{what}: {reason}")]
pub(crate) struct Uncarried {
    /// Topic, connection or wire, such as ``topic `scan` ``.
    pub what: String,
    /// Key under which another codec can be selected.
    pub place: String,
    pub reason: DatumError,
    pub codec: Span,
    pub at: Span,
}

impl Finding for Uncarried {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let place = &self.place;
        diagnostic
            .label(self.at, "the messages have this type")
            .label(self.codec, "encoded as CDR")
            .help(format!(
                "describe the type, or write `codec = \"cbor\"` under `[{place}]`"
            ))
    }
}
