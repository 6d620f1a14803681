use crate::nearest::Suggest;
use crate::nearest::nearest_name;
use crate::wording::has;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unknown field
///
/// The message has no field of this name.
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
/// reply = { topic = "event", map = "cod", none = "NONE" }
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
#[code(C115, error)]
#[error("unknown field `{field}` of `{name}`")]
pub(crate) struct UnknownField {
    pub name: String,
    pub field: String,
    pub at: Span,
    pub known: Vec<String>,
    pub declared: Option<Span>,
}

impl Finding for UnknownField {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            field,
            known,
            declared,
            ..
        } = self;
        if let Some(path) = path_to_element(field, known) {
            return diagnostic
                .label(self.at, "not declared")
                .did_you_mean(self.at, Some(&path));
        }
        let nearest = nearest_name(field, known.iter().map(String::as_str));
        let known = known.iter().map(String::as_str);
        let diagnostic = diagnostic.label(self.at, "not declared");
        let diagnostic = match declared {
            Some(declared) => diagnostic.label(*declared, "type described here"),
            None => diagnostic,
        };
        diagnostic.suggest_or(self.at, &nearest, has("fields", known))
    }
}

/// The path to an element that is written with an index in brackets: `ranges.0` for `ranges[0]`.
fn path_to_element(field: &str, known: &[String]) -> Option<String> {
    let (list, index) = field.strip_suffix(']')?.split_once('[')?;
    let is_element = known.iter().any(|it| it == list) && index.parse::<usize>().is_ok();
    is_element.then(|| format!("{list}.{index}"))
}
