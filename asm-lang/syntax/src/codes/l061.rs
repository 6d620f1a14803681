use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// `<-` without a turbo rule
///
/// `location <- r_x(…)` runs a turbo rule and stores its result. Use `:=` to store the value of a term.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n <- 1
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
#[code(L061, error)]
#[error("expected a turbo rule after `<-`")]
pub(crate) struct ReturnOfNoRule {
    pub at: Span,
}

impl Finding for ReturnOfNoRule {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "expected the name of a rule after this")
            .help("write `:=` to assign the value of a function")
    }
}
