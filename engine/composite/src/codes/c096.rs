use crate::wording::enumerate;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Ambiguous field
///
/// Several fields of the message could be meant, so the binding must name one.
///
/// ```asm
/// asm example
/// signature:
///   enum domain Command = {NOTHING | GET_MAP | STOP}
///   enum domain Reply = {NONE | MAP_OK | FAILED}
///   monitored estop: Boolean
///   monitored reply: Reply
///   controlled tries: Integer
///   out command: Command
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
/// [components.Coordinator]
/// implementation = { asm = "example.asm" }
/// subscribe = { estop = "nav_msgs/Odometry", event = "nav/Event" }
/// publish = { command = "nav/Event" }
///
/// [components.Coordinator.bind.monitored]
/// estop = { topic = "estop" }
/// reply = { topic = "event", map = "code", none = "NONE" }
///
/// [components.Coordinator.bind.out]
/// command = { topic = "command" }
///
/// [[promote]]
/// topic = "estop"
/// as = "estop"
///
/// [[promote]]
/// topic = "event"
/// as = "event"
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
/// [components.Coordinator]
/// implementation = { asm = "example.asm" }
/// subscribe = { estop = "std_msgs/Bool", event = "nav/Event" }
/// publish = { command = "nav/Event" }
///
/// [components.Coordinator.bind.monitored]
/// estop = { topic = "estop" }
/// reply = { topic = "event", map = "code", none = "NONE" }
///
/// [components.Coordinator.bind.out]
/// command = { topic = "command" }
///
/// [[promote]]
/// topic = "estop"
/// as = "estop"
///
/// [[promote]]
/// topic = "event"
/// as = "event"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C096, error)]
#[error("ambiguous field of `{message}` for `{function}`")]
pub(crate) struct AmbiguousField {
    pub function: String,
    pub message: String,
    pub fields: Vec<String>,
    pub at: Span,
}

impl Finding for AmbiguousField {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { fields, .. } = self;
        let fields: Vec<&str> = fields.iter().map(String::as_str).collect();
        diagnostic
            .label(self.at, "several fields match")
            .help(format!(
                "select one with `field = \"…\"`: {}",
                enumerate(&fields)
            ))
    }
}
