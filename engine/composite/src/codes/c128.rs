use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Start depends on a verification that this version cannot do
///
/// `refuse_start_on_failure = true` makes the start of the robot depend on properties of the specification. This version
/// does not verify properties, so it refuses to start rather than start without the verification.
///
/// ```asm
/// asm example
/// import StandardLibrary
/// signature:
///   controlled moving: Boolean
///   controlled permitted: Boolean
/// definitions:
///   invariant over moving, permitted: moving implies permitted
///   main rule r_Main = moving := permitted
/// default init s0:
///   function moving = false
///   function permitted = false
/// ```
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Guard]
/// implementation = { asm = "example.asm" }
/// verify = { ctl = true, refuse_start_on_failure = true }
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
/// [components.Guard]
/// implementation = { asm = "example.asm" }
/// ```
///
/// Invariants of the specification (`invariant over …`) are checked in every step of a run, and end it when they are
/// violated.
#[derive(Debug, thiserror::Error, Coded)]
#[code(C128, error)]
#[error("this version cannot verify `{component}` before it starts")]
pub(crate) struct VerificationNotSupported {
    pub component: String,
    pub at: Span,
}

impl Finding for VerificationNotSupported {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "demands a verification before the start")
            .help("remove the key to run without verification; invariants are checked in every step of a run")
    }
}
