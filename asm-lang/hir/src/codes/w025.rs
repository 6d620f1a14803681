use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Integer instead of a Natural
///
/// AsmetaS converts the number to a Natural. A Natural literal ends in `n`; `asmotion check --fix` adds
/// it.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Natural
/// definitions:
///   main rule r_Main = n := 3
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Natural
/// definitions:
///   main rule r_Main = n := 3n
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(W025, warning)]
#[error("expected a Natural, found an Integer")]
pub(crate) struct IntegerForNatural {
    pub number: String,
    pub at: Span,
}

impl Finding for IntegerForNatural {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "read as the Natural of the same value")
            .fix("add the suffix `n`", self.at, self.number.clone())
    }
}
