use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// `:=` instead of `=`
///
/// `:=` updates a location; `=` compares two values.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = if n := 1 then skip endif
/// default init s0:
///   function n = 1
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
///   main rule r_Main = if n = 1 then skip endif
/// default init s0:
///   function n = 1
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L051, error)]
#[error("expected `=`, found `:=`")]
pub(crate) struct UpdateForEquals {
    pub at: Span,
}

impl Finding for UpdateForEquals {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "updates a location")
            .fix("write `=` to compare", self.at, "=")
    }
}
