use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unterminated comment
///
/// A comment that starts with `/*` ends at the next `*/`. Without one it extends to the end of the
/// file.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n := 1 /* the only rule
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
///   main rule r_Main = n := 1 /* the only rule */
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L003, error)]
#[error("unterminated comment")]
pub(crate) struct OpenComment {
    pub open: Span,
}

impl Finding for OpenComment {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.open, "starts here and is never closed")
            .help("close it with `*/`")
    }
}
