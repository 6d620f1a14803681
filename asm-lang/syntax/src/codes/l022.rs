use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Second heading
///
/// A file contains one `asm` or one `module`.
///
/// ```asm wrong
/// asm example
/// module other
/// signature:
/// definitions:
///   main rule r_Main = skip
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// signature:
/// definitions:
///   main rule r_Main = skip
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L022, error)]
#[error("duplicate heading")]
pub(crate) struct SecondHeading {
    pub at: Span,
    pub first: Span,
}

impl Finding for SecondHeading {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "second heading")
            .label(self.first, "first heading")
            .help("keep one `asm` or `module` in a file; move the other to its own file")
    }
}
