use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// `div` as an operator
///
/// `div` is a function. `idiv(a, b)` is the quotient of two integers, truncated towards zero; `a / b` is a real number.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n := n div 2
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
///   main rule r_Main = n := idiv(n, 2)
/// default init s0:
///   function n = 1
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L078, error)]
#[error("`div` is not an operator")]
pub(crate) struct InfixDivision {
    pub at: Span,
}

impl Finding for InfixDivision {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "a function, which stands before its arguments")
            .help(
                "write `idiv(a, b)` for the quotient of two integers, or `a / b` for a real number",
            )
    }
}
