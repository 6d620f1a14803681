use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Assignment to a variable
///
/// The new value is visible to the rules that follow in the same `seq` and is lost afterwards. Use a
/// controlled function to keep it.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = let ($x = 1) in seq $x := 2 n := $x endseq endlet
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
///   main rule r_Main = seq n := 1 n := 2 endseq
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(W020, warning)]
#[error("assignment to variable `{name}`")]
pub(crate) struct WritesVariable {
    pub name: Arc<str>,
    pub at: Span,
    pub bound: Span,
}

impl Finding for WritesVariable {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "assigned here, for the following rules of a `seq`")
            .label(self.bound, "bound here, for this rule only")
            .help("update a controlled function to keep the value")
    }
}
