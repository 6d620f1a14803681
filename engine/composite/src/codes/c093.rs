use crate::nearest::Suggest;
use crate::nearest::nearest_name;
use crate::wording::enumerate;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unknown literal
///
/// The text must be one of the literals of the function's domain.
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
/// estop = { topic = "estop" }
/// reply = { topic = "event", map = "code", none = "NOTHING" }
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
#[code(C093, error)]
#[error("unknown literal `{literal}` of `{domain}`")]
pub(crate) struct UnknownLiteral {
    pub literal: String,
    pub domain: String,
    pub literals: Vec<String>,
    pub at: Span,
    pub declared: Span,
}

impl Finding for UnknownLiteral {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { literal, .. } = self;
        let known: Vec<&str> = self.literals.iter().map(String::as_str).collect();
        let nearest = nearest_name(literal, known.iter().copied());
        diagnostic
            .label(self.at, "not a literal of the domain")
            .label(self.declared, "domain declared here")
            .help(format!("write {}", enumerate(&known)))
            .suggest(self.at, &nearest)
    }
}
