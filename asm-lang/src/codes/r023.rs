use crate::foreign::Foreign;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Update of a location that does not exist
///
/// A function over a subset has locations only for the elements of that subset. Reading any other
/// location yields undef; updating one is an error.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   domain Seat subsetof Integer
///   controlled taken: Seat -> Boolean
///   controlled next: Integer
/// definitions:
///   domain Seat = {1 : 3}
///   main rule r_Main = par taken(next) := true  next := next + 1 endpar
/// default init s0:
///   function next = 1
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   domain Seat subsetof Integer
///   controlled taken: Seat -> Boolean
///   controlled next: Integer
/// definitions:
///   domain Seat = {1 : 3}
///   main rule r_Main = if next <= 3 then par taken(next) := true  next := next + 1 endpar endif
/// default init s0:
///   function next = 1
/// ```
///
/// AsmetaS checks only the values of updates against their domain; `--compat asmeta` does the same.
#[derive(Debug, thiserror::Error, Coded)]
#[code(R023, error)]
#[error("{foreign} {when}")]
pub(crate) struct WritesNowhere {
    pub location: String,
    pub foreign: Foreign,
    pub when: String,
    pub at: Span,
}

impl Finding for WritesNowhere {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let place = format!("location `{}` does not exist", self.location);
        self.foreign
            .explain(diagnostic.label(self.at, place), "guard the update")
    }
}
