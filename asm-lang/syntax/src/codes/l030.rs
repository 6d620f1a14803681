use crate::edits::SpannedText;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unexpected end of the file
///
/// A block or bracket is still open at the end of the file. The message shows which.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = if true then n := 1
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
///   main rule r_Main = if true then n := 1 endif
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L030, error)]
#[error("unexpected end of file: expected {missing}")]
pub(crate) struct FileCutOff {
    pub missing: String,
    pub at: Span,
    pub open: Vec<SpannedText>,
}

impl Finding for FileCutOff {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { missing, .. } = self;
        let found = diagnostic.label(self.at, format!("expected {missing}"));
        self.open.iter().fold(found, |found, (word, span)| {
            found.label(*span, format!("unclosed `{word}`"))
        })
    }
}
