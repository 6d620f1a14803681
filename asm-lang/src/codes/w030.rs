use crate::explain::outside::Foreign;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// An initial value outside its domain
///
/// A run should begin in a state in which every location holds an element of its codomain, or undef. That
/// goes for the parts of tuples, sequences, sets, bags and maps, too. It runs all the same; an update that
/// writes the value again would fail (R002).
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   domain Speed subsetof Integer
///   controlled speed: Speed
/// definitions:
///   domain Speed = {0 : 3}
///   main rule r_Main = speed := 1
/// default init s0:
///   function speed = 9
/// ```
///
/// Mended:
///
/// ```asm mended
/// asm example
/// import StandardLibrary
/// signature:
///   domain Speed subsetof Integer
///   controlled speed: Speed
/// definitions:
///   domain Speed = {0 : 3}
///   main rule r_Main = speed := 1
/// default init s0:
///   function speed = 3
/// ```
///
/// AsmetaS holds only updates against their domain; with `--compat asmeta` nothing is said of it.
#[derive(Debug, thiserror::Error, Coded)]
#[code(W030, warning)]
#[error("{foreign}, in the initial state")]
pub(crate) struct BeginsOutside {
    pub location: String,
    pub foreign: Foreign,
    pub at: Span,
}

impl Finding for BeginsOutside {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let place = format!("the initial value of `{}`", self.location);
        self.foreign.explain(
            diagnostic.label(self.at, place),
            "let it begin with an element",
        )
    }
}
