use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// `=` instead of `:=`
///
/// `=` compares two values; `:=` updates a location.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n = 1
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
///   main rule r_Main = n := 1
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L050, error)]
#[error("expected `:=`, found `=`")]
pub(crate) struct EqualsForUpdate {
    pub at: Span,
}

impl Finding for EqualsForUpdate {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic.label(self.at, "compares two terms").fix(
            "write `:=` to update a location",
            self.at,
            ":=",
        )
    }
}
