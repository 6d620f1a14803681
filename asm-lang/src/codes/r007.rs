use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Value is not a rule
///
/// A location of domain Rule can be run only after a rule was stored in it.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled act: Rule
/// definitions:
///   main rule r_Main = act
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled act: Rule
/// definitions:
///   rule r_act = skip
///   main rule r_Main = act
/// default init s0:
///   function act = <<r_act>>
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(R007, error)]
#[error("expected a rule, found {value} {when}")]
pub(crate) struct RunsNoRule {
    pub value: String,
    pub when: String,
    pub at: Span,
}

impl Finding for RunsNoRule {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "expected a rule")
            .help("assign a rule to the location, as in `<<r_x>>`")
    }
}
