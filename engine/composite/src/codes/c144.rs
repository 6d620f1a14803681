use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Location bound twice
///
/// Each location has one binding. A variable stands for all elements of its domain.
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
/// subscribe = { "ROB1/wants" = "std_msgs/Bool", "ROB2/wants" = "std_msgs/Bool" }
///
/// [components.Coordinator.bind.monitored]
/// "wants($r)" = { topic = "$r/wants" }
/// "wants(ROB2)" = { topic = "ROB1/wants" }
///
/// [[promote]]
/// topic = "ROB1/wants"
/// as = "ROB1/wants"
///
/// [[promote]]
/// topic = "ROB2/wants"
/// as = "ROB2/wants"
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
/// subscribe = { "ROB1/wants" = "std_msgs/Bool", "ROB2/wants" = "std_msgs/Bool" }
///
/// [components.Coordinator.bind.monitored]
/// "wants($r)" = { topic = "$r/wants" }
///
/// [[promote]]
/// topic = "ROB1/wants"
/// as = "ROB1/wants"
///
/// [[promote]]
/// topic = "ROB2/wants"
/// as = "ROB2/wants"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C144, error)]
#[error("`{location}` is bound twice")]
pub(crate) struct LocationBoundTwice {
    pub location: String,
    pub at: Span,
    pub first: Span,
}

impl Finding for LocationBoundTwice {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "bound again here")
            .label(self.first, "first bound here")
            .help("remove one of the bindings, or list the other locations one by one")
    }
}
