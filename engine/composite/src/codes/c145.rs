use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Invalid term of a binding
///
/// The condition of a timer, and a value of the specification in an argument (`"@(term)"`), are terms in the language of
/// the specification, with its functions and literals. A condition is Boolean.
///
/// ```asm
/// asm example
/// import StandardLibrary
/// signature:
///   enum domain Mode = {DRIVING | CHARGING}
///   monitored chargeTimeout: Boolean
///   controlled mode: Mode
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
/// activity = { period_ms = 100 }
///
/// [components.Coordinator.bind.monitored]
/// chargeTimeout = { timer = "mode = CHARGED", ms = 20000 }
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
/// activity = { period_ms = 100 }
///
/// [components.Coordinator.bind.monitored]
/// chargeTimeout = { timer = "mode = CHARGING", ms = 20000 }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C145, error)]
#[error("invalid term `{term}`: {reason}")]
pub(crate) struct InvalidTerm {
    pub term: String,
    pub reason: String,
    pub at: Span,
}

impl Finding for InvalidTerm {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "not a term of the specification")
            .help("write a term as in a rule: functions, literals, operators")
    }
}
