use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// `*` between domains
///
/// `*` multiplies numbers. The domain of a function with two arguments is the product `Prod(A, B)`.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled at: Integer * Integer -> Integer
/// definitions:
///   main rule r_Main = skip
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled at: Prod(Integer, Integer) -> Integer
/// definitions:
///   main rule r_Main = at(1, 2) := 3
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L059, error)]
#[error("unexpected `*` between domains")]
pub(crate) struct ProductSign {
    pub at: Span,
}

impl Finding for ProductSign {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "`*` multiplies numbers")
            .help("write `Prod(A, B) -> C` for a function with two arguments")
    }
}
