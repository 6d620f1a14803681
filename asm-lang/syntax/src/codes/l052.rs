use crate::edits::SpannedText;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Missing keyword
///
/// This construct needs another keyword, as in `if … then … endif` or `forall … do …`.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled at: Integer -> Integer
/// definitions:
///   main rule r_Main = forall $x in {1 : 3} at($x) := 0
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
#[code(L052, error)]
#[error("expected `{word}` after {after}")]
pub(crate) struct MissingWord {
    pub word: &'static str,
    pub after: String,
    pub at: Span,
    pub opener: Option<SpannedText>,
}

impl Finding for MissingWord {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { word, opener, .. } = self;
        let missing = diagnostic.label(self.at, format!("expected `{word}` before this"));
        match opener {
            Some((word, span)) => missing.label(*span, format!("this `{word}`")),
            None => missing,
        }
    }
}
