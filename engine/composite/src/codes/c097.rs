use crate::signature::FunctionInfo;
use crate::wording::missing;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unbound monitored function
///
/// The specification reads this function, but nothing provides its value, so it stays undef.
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
#[code(C097, warning)]
#[error("unbound monitored {} undef", subject(self))]
pub(crate) struct UnboundMonitored {
    pub function: FunctionInfo,
    /// Locations without a binding; empty if the function has none at all.
    pub missing: Vec<String>,
    pub at: Span,
}

fn subject(unbound: &UnboundMonitored) -> String {
    let function = &unbound.function.name;
    match unbound.missing.as_slice() {
        [] => format!("function `{function}` stays"),
        _ => format!("locations of `{function}` stay"),
    }
}

impl Finding for UnboundMonitored {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(
                self.at,
                format!("no binding for {}", missing(&self.function, &self.missing)),
            )
            .label(self.function.declared, "declared `monitored` here")
            .help(format!(
                "add `{}` to `bind.monitored`",
                self.function.binding_example(&self.missing)
            ))
    }
}
