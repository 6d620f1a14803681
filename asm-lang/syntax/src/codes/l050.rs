use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// `=` where an update is meant
///
/// `=` asks whether two values are equal; `:=` gives a location its next value.
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
/// Mended:
///
/// ```asm mended
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n := 1
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L050, error)]
#[error("`=` compares; an update is written `:=`")]
pub(crate) struct EqualsForUpdate {
    pub at: Span,
}

impl Finding for EqualsForUpdate {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "compares")
            .fix("write an update", self.at, ":=")
    }
}
