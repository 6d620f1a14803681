use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// No main rule
///
/// Each step of an `asm` runs its main rule. A file that is only imported should be a `module`.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   rule r_set = n := 1
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
///   rule r_set = n := 1
///   main rule r_Main = r_set[]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(W005, warning)]
#[error("`{name}` has no main rule")]
pub(crate) struct NoMainRule {
    pub name: Arc<str>,
    pub at: Span,
}

impl Finding for NoMainRule {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "this `asm` cannot run")
            .help("add `main rule r_Main = …`, or declare it as a `module`")
    }
}
