use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Key of an unknown variable
///
/// A key gives for a variable of the location the field of the message that selects the element.
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
/// "wants($r)" = { topic = "wants", key = { robot = "code" }, edge = true }
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
#[code(C142, error)]
#[error("unknown variable `${variable}` of the bound location")]
pub(crate) struct UnknownKeyVariable {
    pub variable: String,
    pub at: Span,
}

impl Finding for UnknownKeyVariable {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "not a variable of the location")
            .help("name the variable, without its dollar sign, in `key`")
    }
}
