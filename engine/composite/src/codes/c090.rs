use crate::nearest::Nearest;
use crate::nearest::Suggest;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unknown bound function
///
/// A binding connects a function of the specification with a message. The specification has no function
/// of this name.
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
/// estopp = { topic = "estop" }
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
#[code(C090, error)]
#[error("unknown function `{name}` of the specification")]
pub(crate) struct UnknownBoundFunction {
    pub name: String,
    pub at: Span,
    pub nearest: Option<Nearest>,
}

impl Finding for UnknownBoundFunction {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { nearest, .. } = self;
        diagnostic
            .label(self.at, "bound here")
            .suggest(self.at, nearest)
    }
}
