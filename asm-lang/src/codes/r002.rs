use crate::foreign::Foreign;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Written value outside its domain
///
/// A function whose codomain is a subset accepts only elements of that subset, and undef.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   domain Speed subsetof Integer
///   controlled speed: Speed
/// definitions:
///   domain Speed = {0 : 3}
///   main rule r_Main = speed := speed + 1
/// default init s0:
///   function speed = 3
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
///   main rule r_Main = if speed < 3 then speed := speed + 1 endif
/// default init s0:
///   function speed = 3
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(R002, error)]
#[error("{foreign} {when}")]
pub(crate) struct WritesForeignValue {
    pub location: String,
    /// Codomain of the function, as text.
    pub codomain: String,
    pub foreign: Foreign,
    pub when: String,
    pub at: Span,
}

impl Finding for WritesForeignValue {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let place = format!("`{}` takes values of `{}`", self.location, self.codomain);
        self.foreign
            .explain(diagnostic.label(self.at, place), "guard the update")
    }
}
