use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Library function without a value
///
/// The library function has no value for these arguments, as in an overflow, a division by zero, or a
/// position beyond the end of a sequence.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n := idiv(1, n)
/// default init s0:
///   function n = 0
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
///   main rule r_Main = if n != 0 then n := idiv(1, n) endif
/// default init s0:
///   function n = 0
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(R004, error)]
#[error("{reason} {when}")]
pub(crate) struct LibraryFault {
    /// The reason, with a suggestion.
    pub reason: String,
    pub help: &'static str,
    pub when: String,
    pub at: Span,
}

impl Finding for LibraryFault {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic.label(self.at, "evaluated here").help(self.help)
    }
}
