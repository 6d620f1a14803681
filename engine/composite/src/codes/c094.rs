use crate::signature::FunctionInfo;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Wrong type of substitute value
///
/// A value that replaces a missing or outdated message must belong to the domain of the function.
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
/// subscribe = { estop = "std_msgs/Bool", event = "nav/Event" }
/// publish = { command = "nav/Event" }
///
/// [components.Coordinator.bind.monitored]
/// estop = { topic = "estop", stale_ms = 300, on_stale = "yes" }
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
#[code(C094, error)]
#[error("mismatched types: `{}` takes {}, not {found}", function.name, function.codomain.name())]
pub(crate) struct WrongLiteralType {
    pub function: FunctionInfo,
    pub found: String,
    pub at: Span,
}

impl Finding for WrongLiteralType {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(
                self.at,
                format!("expected `{}`", self.function.codomain.name()),
            )
            .label(self.function.declared, "declared here")
            .help(format!(
                "write a value of `{}`",
                self.function.codomain.name()
            ))
    }
}
