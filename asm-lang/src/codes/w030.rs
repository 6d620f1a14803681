use crate::foreign::Foreign;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Initial value outside its domain
///
/// In the initial state every location should hold an element of its codomain, or undef. This includes
/// the parts of tuples, sequences, sets, bags and maps. The run starts nevertheless, but an update that
/// writes the same value would fail (R002).
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
/// Corrected:
///
/// ```asm corrected
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
/// AsmetaS checks only updates against their domain; with `--compat asmeta` this warning is not
/// reported.
#[derive(Debug, thiserror::Error, Coded)]
#[code(W030, warning)]
#[error("{foreign} in the initial state")]
pub(crate) struct BeginsOutside {
    pub location: String,
    pub foreign: Foreign,
    pub at: Span,
}

impl Finding for BeginsOutside {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let place = format!("initial value of `{}`", self.location);
        self.foreign.explain(
            diagnostic.label(self.at, place),
            "initialise it with an element",
        )
    }
}
