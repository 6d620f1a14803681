use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Range is not a collection
///
/// `forall`, `exists`, `choose` and comprehensions range over a domain, a set, a sequence or a bag.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled at: Integer -> Integer
/// definitions:
///   main rule r_Main = forall $x in 3 do at($x) := 0
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled at: Integer -> Integer
/// definitions:
///   main rule r_Main = forall $x in {1 : 3} do at($x) := 0
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A018, error)]
#[error("expected a collection for `{name}`, found {actual}")]
pub(crate) struct NotACollection {
    pub name: Arc<str>,
    pub actual: String,
    pub at: Span,
}

impl Finding for NotACollection {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "expected a set, sequence or bag")
            .help("range over a domain, a set, a sequence or a bag")
    }
}
