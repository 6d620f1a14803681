use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// More threads than the connection allows
///
/// Each component runs in its own thread unless it has a `master`. `max_threads` limits how many
/// threads may use the connection.
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
/// [components.Rover]
/// implementation = { process = "rover" }
/// ports.in = { twist = "geometry_msgs/Twist" }
///
/// [[connections]]
/// from = "Joystick.twist"
/// to = "Rover.twist"
/// policy = { type = "data", max_threads = 1 }
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
/// [components.Rover]
/// implementation = { process = "rover" }
/// ports.in = { twist = "geometry_msgs/Twist" }
///
/// [[connections]]
/// from = "Joystick.twist"
/// to = "Rover.twist"
/// policy = { type = "data", max_threads = 2 }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C058, error)]
#[error("{threads} threads use a connection that allows {max}")]
pub(crate) struct TooManyThreads {
    pub threads: u64,
    pub max: u64,
    pub at: Span,
    pub ends: Span,
}

impl Finding for TooManyThreads {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { threads, .. } = self;
        diagnostic
            .label(self.at, "too low")
            .label(self.ends, "read in a separate thread")
            .help(format!(
                "write {threads}, or remove `max_threads`; connections of asmotion do not need it"
            ))
    }
}
