use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Verification of properties that the specification does not state
///
/// `verify` selects the kinds of properties that are verified before the start. A kind of which the specification states no
/// property has no effect.
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
/// verify = { invariants = true, refuse_start_on_failure = true }
/// ```
///
/// `asmotion verify` verifies the composite without a start.
#[derive(Debug, thiserror::Error, Coded)]
#[code(C128, warning)]
#[error("the specification of `{component}` states no {kind} to verify")]
pub(crate) struct NothingToVerify {
    pub component: String,
    /// Kind of the property, in words.
    pub kind: &'static str,
    pub at: Span,
}

impl Finding for NothingToVerify {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "has no effect")
            .help("remove the key, or state a property in the specification")
    }
}
