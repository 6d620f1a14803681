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
/// Mended:
///
/// ```asm mended
/// asm example
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n := 1
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L021, error)]
#[error("the file does not begin with `asm` or `module` and a name")]
pub(crate) struct NoHeading {
    pub at: Span,
}

impl Finding for NoHeading {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "begins here")
            .help("write `asm name` first, with the name of the file")
    }
}
