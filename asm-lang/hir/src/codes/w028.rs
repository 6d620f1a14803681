use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Argument of a larger domain
///
/// The function is declared for a smaller domain than that of its argument, so some values may be
/// outside of it.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   abstract domain Animal
///   domain Dog subsetof Animal
///   static cow: Animal
///   controlled barks: Dog -> Boolean
/// definitions:
///   main rule r_Main = forall $a in Animal do barks($a) := true
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   abstract domain Animal
///   domain Dog subsetof Animal
///   static cow: Animal
///   controlled barks: Dog -> Boolean
/// definitions:
///   main rule r_Main = forall $a in Dog do barks($a) := true
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(W028, warning)]
#[error("`{name}` is declared for {expected}, but this may be any {actual}")]
pub(crate) struct ArgumentTooWide {
    pub name: Arc<str>,
    pub expected: String,
    pub actual: String,
    pub at: Span,
    pub declared: Span,
}

impl Finding for ArgumentTooWide {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            expected: wanted, ..
        } = self;
        diagnostic
            .label(self.at, format!("may not be an element of {wanted}"))
            .label(self.declared, "declared here")
            .help("use the smaller domain, or declare the function for the larger one")
    }
}
