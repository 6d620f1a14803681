use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// An Integer where a Natural is wanted
///
/// AsmetaS takes the number for the Natural of the same size. A Natural is written with an `n`;
/// `asmotion check --fix` writes it so.
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
/// Mended:
///
/// ```asm mended
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Natural
/// definitions:
///   main rule r_Main = n := 3n
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(W025, warning)]
#[error("a Natural is wanted, this is an Integer")]
pub(crate) struct IntegerForNatural {
    pub number: String,
    pub at: Span,
}

impl Finding for IntegerForNatural {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "taken for the Natural of this size")
            .fix("a Natural is written so", self.at, self.number.clone())
    }
}
