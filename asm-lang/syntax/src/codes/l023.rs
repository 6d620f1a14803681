use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Second `export`
///
/// A module has one `export` clause for all its names. `export *` exports everything.
///
/// ```asm wrong
/// module example
/// export Speed
/// export limit
/// signature:
///   domain Speed subsetof Integer
///   static limit: Integer
/// definitions:
///   domain Speed = {0 : 9}
///   function limit = 9
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// module example
/// export Speed, limit
/// signature:
///   domain Speed subsetof Integer
///   static limit: Integer
/// definitions:
///   domain Speed = {0 : 9}
///   function limit = 9
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L023, error)]
#[error("duplicate `export`")]
pub(crate) struct SecondExport {
    pub at: Span,
    pub first: Span,
}

impl Finding for SecondExport {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "second `export`")
            .label(self.first, "first `export`")
            .help("list all names in one `export`, separated by commas")
    }
}
