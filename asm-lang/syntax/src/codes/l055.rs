use crate::edits::SpannedText;
use asmotion_diagnostics::{Coded, Diagnostic, Finding};

/// Complex number as a name
///
/// `i` is the imaginary unit, so `i`, `i2` and `1+i2` are numbers.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled i2: Integer
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
///   controlled index2: Integer
/// definitions:
///   main rule r_Main = skip
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L055, error)]
#[error("`{}` is a complex number and cannot name {what}", found.0)]
pub(crate) struct ComplexName {
    pub found: SpannedText,
    pub what: &'static str,
}

impl Finding for ComplexName {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.found.1, "complex number")
            .note("`i` is the imaginary unit: `i`, `i2` and `1+i2` are numbers")
            .help("choose another name")
    }
}
