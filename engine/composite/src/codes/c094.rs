use crate::signature::{Codomain, FunctionInfo};
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
                "write a value of `{}`, such as `{}`",
                self.function.codomain.name(),
                example(&self.function.codomain)
            ))
    }
}

/// Returns a value of a codomain as a composite writes it.
fn example(codomain: &Codomain) -> String {
    match codomain {
        Codomain::Boolean => "false".to_owned(),
        Codomain::Integer => "0".to_owned(),
        Codomain::Real => "0.5".to_owned(),
        Codomain::Text | Codomain::Other(_) => "\"text\"".to_owned(),
        Codomain::Character => "\"c\"".to_owned(),
        Codomain::Abstract(_) => "\"element\"".to_owned(),
        Codomain::Enum { literals, .. } => {
            format!("\"{}\"", literals.first().map_or("LITERAL", String::as_str))
        }
        Codomain::List { item, .. } => format!("[{}]", example(item)),
        Codomain::Tuple { items, .. } => {
            let items: Vec<String> = items.iter().map(example).collect();
            format!("[{}]", items.join(", "))
        }
        // keys are names of fields, which are quoted if they are no words
        Codomain::Map { key, item, .. } => {
            let is_text = matches!(**key, Codomain::Text);
            let key = if is_text {
                "name".to_owned()
            } else {
                example(key)
            };
            format!("{{ {key} = {} }}", example(item))
        }
    }
}
