use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Rule without a result
///
/// Only a turbo rule has a result: it updates `result`. A macro is replaced by its body.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   rule r_one = skip
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
#[code(A024, error)]
#[error("`{name}` has no result")]
pub(crate) struct RuleWithoutResult {
    pub name: Arc<str>,
    pub at: Span,
    pub declared: Span,
}

impl Finding for RuleWithoutResult {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "its result is used here")
            .label(self.declared, "macro rules have no result")
            .help("declare `turbo rule r_x(…) in D = …` and update `result` in it")
    }
}
