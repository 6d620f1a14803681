use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Square brackets around function arguments
///
/// Square brackets call a rule. The arguments of a function are written in round brackets.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled at: Integer -> Integer
/// definitions:
///   main rule r_Main = at[1] := 5
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled at: Integer -> Integer
/// definitions:
///   main rule r_Main = at(1) := 5
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L041, error)]
#[error("square brackets around function arguments")]
pub(crate) struct SquareArguments {
    pub at: Span,
}

impl Finding for SquareArguments {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "square brackets call a rule")
            .help("write parentheses, as in `f(x) := …`")
    }
}
