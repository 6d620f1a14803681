use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Several writers of one value
///
/// A `data` connection keeps only the last value, so the reader would see values of both writers in
/// turn. A buffer keeps the values of both; an arbiter component can decide between them.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Joystick]
/// implementation = { process = "joystick" }
/// ports.out = { twist = "geometry_msgs/Twist" }
///
/// [components.Remote]
/// implementation = { process = "remote" }
/// ports.out = { twist = "geometry_msgs/Twist" }
///
/// [components.Rover]
/// implementation = { process = "rover" }
/// ports.in = { twist = "geometry_msgs/Twist" }
///
/// [[connections]]
/// from = ["Joystick.twist", "Remote.twist"]
/// to = "Rover.twist"
/// policy = { type = "data" }
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
/// [components.Remote]
/// implementation = { process = "remote" }
/// ports.out = { twist = "geometry_msgs/Twist" }
///
/// [components.Rover]
/// implementation = { process = "rover" }
/// ports.in = { twist = "geometry_msgs/Twist" }
///
/// [[connections]]
/// from = ["Joystick.twist", "Remote.twist"]
/// to = "Rover.twist"
/// policy = { type = "circular_buffer", size = 8 }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C043, error)]
#[error("two writers of `{port}`, which keeps only the last value")]
pub(crate) struct TwoWriters {
    pub port: String,
    pub at: Span,
    pub first: Span,
}

impl Finding for TwoWriters {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "second writer")
            .label(self.first, "first writer")
            .help("queue both with `type = \"buffer\"` and a `size`, or remove one of them")
    }
}
