use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Comma between rules
///
/// Rules follow each other without a separator.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled a: Integer
///   controlled b: Integer
/// definitions:
///   main rule r_Main = par a := 1, b := 2 endpar
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled a: Integer
///   controlled b: Integer
/// definitions:
///   main rule r_Main = par a := 1 b := 2 endpar
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L040, error)]
#[error("unexpected `,` between rules")]
pub(crate) struct CommaBetweenRules {
    pub at: Span,
}

impl Finding for CommaBetweenRules {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "rules are not separated")
            .fix("remove it", self.at, "")
    }
}
