use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// `in` as an operator
///
/// `in` only binds variables. Use `contains(set, element)` to test membership.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = if n in {1, 2} then skip endif
/// default init s0:
///   function n = 1
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
///   main rule r_Main = if contains({1, 2}, n) then skip endif
/// default init s0:
///   function n = 1
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L060, error)]
#[error("`in` is not an operator")]
pub(crate) struct InfixMembership {
    pub at: Span,
}

impl Finding for InfixMembership {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "`in` only binds variables")
            .help("write `contains(set, element)` to test membership")
    }
}
