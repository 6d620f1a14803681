use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Integer too large
///
/// Integers have 64 bits; the largest is 9223372036854775807.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n := 99999999999999999999
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
///   main rule r_Main = n := 9223372036854775807
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L006, error)]
#[error("integer `{digits}` is too large")]
pub(crate) struct IntegerTooLarge {
    pub digits: String,
    pub at: Span,
}

impl Finding for IntegerTooLarge {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "does not fit into 64 bits")
            .note(format!("the largest integer is {}", i64::MAX))
    }
}
