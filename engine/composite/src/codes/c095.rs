use crate::signature::FunctionInfo;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Wrong type of field
///
/// The type of the field must match the function: a Boolean function takes a Boolean field, a number a
/// number, and an enumeration a string together with `map`.
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
/// estop = { topic = "event", field = "code" }
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
#[code(C095, error)]
#[error("mismatched types: `{}` takes {}, not {found}", function.name, function.codomain.name())]
pub(crate) struct WrongFieldType {
    pub function: FunctionInfo,
    pub found: String,
    pub at: Span,
    pub typed: Option<Span>,
}

impl Finding for WrongFieldType {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { typed, .. } = self;
        let is_collection = self.function.codomain.name().contains('(');
        let help = if self.found.trim_end_matches('`').ends_with(']') && !is_collection {
            "bind a field of the function's type; the path to an element of a list ends with its number, as in `ranges.0`"
        } else {
            "bind a field of the function's type; `map` converts a string to a literal, and `edge = true` gives a Boolean"
        };
        let diagnostic = diagnostic
            .label(self.at, "bound here")
            .label(self.function.declared, "declared here")
            .help(help);
        match typed {
            Some(typed) => diagnostic.label(*typed, "message described here"),
            None => diagnostic,
        }
    }
}
