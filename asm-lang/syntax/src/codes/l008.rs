use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Missing digits after the point
///
/// A real number has digits on both sides of the point.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled x: Real
/// definitions:
///   main rule r_Main = x := 2.
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled x: Real
/// definitions:
///   main rule r_Main = x := 2.0
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L008, error)]
#[error("missing digits after the decimal point")]
pub(crate) struct BarePoint {
    pub number: String,
    pub at: Span,
}

impl Finding for BarePoint {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { number, .. } = self;
        diagnostic.label(self.at, "incomplete number").fix(
            "add a digit after the point",
            self.at,
            format!("{number}0"),
        )
    }
}
