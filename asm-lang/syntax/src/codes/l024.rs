use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Second main rule
///
/// A step of the machine runs the main rule once, so there is only one.
///
/// ```asm wrong
/// asm example
/// signature:
/// definitions:
///   main rule r_First = skip
///   main rule r_Second = skip
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// signature:
/// definitions:
///   rule r_First = skip
///   rule r_Second = skip
///   main rule r_Main =
///     par
///       r_First[]
///       r_Second[]
///     endpar
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L024, error)]
#[error("duplicate main rule")]
pub(crate) struct SecondMain {
    pub at: Span,
    pub first: Span,
}

impl Finding for SecondMain {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "second main rule")
            .label(self.first, "first main rule")
            .help("remove `main` from one of them")
    }
}
