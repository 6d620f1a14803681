use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Undeclared result of a turbo rule
///
/// The domain of the result should be declared, so that returned values can be checked.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   turbo rule r_one = result := 1
///   main rule r_Main = n <- r_one()
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
///   turbo rule r_one in Integer = result := 1
///   main rule r_Main = n <- r_one()
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(W022, warning)]
#[error("`{name}` does not declare its result")]
pub(crate) struct ResultUndeclared {
    pub name: Arc<str>,
    pub at: Span,
    pub declared: Span,
}

impl Finding for ResultUndeclared {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "its result is used here")
            .label(self.declared, "declared without `in Domain`")
            .help("declare `turbo rule r_x(…) in D = …` to have the result checked")
    }
}
