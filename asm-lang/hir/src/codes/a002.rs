use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Unknown variable
///
/// A variable starts with `$`. It is bound by `let`, `forall`, `choose`, `extend` or a quantifier, or
/// it is a parameter.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n := $x
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
///   main rule r_Main = let ($x = 1) in n := $x endlet
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A002, error)]
#[error("unknown variable `{name}`")]
pub(crate) struct UnknownVariable {
    pub name: Arc<str>,
    pub at: Span,
    pub similar: Option<Arc<str>>,
}

impl Finding for UnknownVariable {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic.label(self.at, "not bound here").did_you_mean_or(
            self.at,
            self.similar.as_deref(),
            "bind it with `let`, `forall` or `choose`, or declare it as a parameter of the rule",
        )
    }
}
