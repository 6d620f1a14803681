use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Missing heading
///
/// A file starts with `asm name`, or with `module name` if it is only imported.
///
/// ```asm wrong
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n := 1
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n := 1
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L021, error)]
#[error("missing `asm` or `module` at the start of the file")]
pub(crate) struct NoHeading {
    pub at: Span,
}

impl Finding for NoHeading {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "expected `asm` or `module` before this")
            .help("start the file with `asm name`, using the name of the file")
    }
}
