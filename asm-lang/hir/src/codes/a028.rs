use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Term instead of a rule
///
/// A rule changes the state, as an update, a call or a block does. A term only has a value.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n + 1
/// default init s0:
///   function n = 0
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n := n + 1
/// default init s0:
///   function n = 0
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A028, error)]
#[error("expected a rule, found a term of type {actual}")]
pub(crate) struct NotARule {
    pub actual: String,
    pub at: Span,
}

impl Finding for NotARule {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "expected a rule")
            .help("write an update as `location := term`, or a macro call as `r_name[…]`")
    }
}
