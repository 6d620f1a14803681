use crate::signature::ParameterInfo;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Wrong type of a key field
///
/// The field of a key names an element: a string names a literal or a constant, and a number an element of integers.
///
/// ```asm
/// asm example
/// signature:
///   enum domain Robot = {ROB1 | ROB2}
///   monitored wants: Robot -> Boolean
///   controlled tries: Integer
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
/// subscribe = { "wants" = "nav/Event" }
///
/// [components.Coordinator.bind.monitored]
/// "wants($r)" = { topic = "wants", key = { r = "stamp" }, edge = true }
///
/// [[promote]]
/// topic = "wants"
/// as = "wants"
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
/// subscribe = { "wants" = "nav/Event" }
///
/// [components.Coordinator.bind.monitored]
/// "wants($r)" = { topic = "wants", key = { r = "code" }, edge = true }
///
/// [[promote]]
/// topic = "wants"
/// as = "wants"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C143, error)]
#[error("mismatched types: `${variable}` ranges over `{}`, but the field is `{found}`", parameter.name)]
pub(crate) struct WrongSelectorType {
    pub variable: String,
    pub parameter: ParameterInfo,
    pub found: String,
    pub at: Span,
    pub declared: Option<Span>,
}

impl Finding for WrongSelectorType {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let diagnostic = diagnostic.label(self.at, "names no element");
        let diagnostic = match self.declared {
            Some(declared) => diagnostic.label(declared, "declared here"),
            None => diagnostic,
        };
        diagnostic.help("select the element by a field that contains its name")
    }
}
