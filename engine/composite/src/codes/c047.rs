use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unsynchronised connection between threads
///
/// An `unsync` connection has no synchronisation, so both ends must run in the same thread. `activity =
/// { master = … }` makes one component run in the thread of the other.
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
/// policy = { type = "data", lock = "unsync" }
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
/// policy = { type = "data", lock = "lock_free" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C047, error)]
#[error("`lock = \"unsync\"` needs both ends in one thread")]
pub(crate) struct UnsyncAcrossThreads {
    pub from: String,
    pub to: String,
    pub at: Span,
    pub ends: Span,
}

impl Finding for UnsyncAcrossThreads {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { from, to, .. } = self;
        diagnostic
            .label(self.at, "not thread-safe here")
            .label(self.ends, "connects two threads")
            .help(format!(
                "use `lock_free`, or run one component after the other with `activity.master` of `{to}` or `{from}`"
            ))
    }
}
