use crate::edits::SpannedText;
use asmotion_diagnostics::{Coded, Diagnostic, Finding};

/// Misspelt keyword
///
/// The language has no such word, but one that is spelt almost the same is allowed here.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controled n: Integer
/// definitions:
///   main rule r_Main = n := 1
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
///   main rule r_Main = n := 1
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L053, error)]
#[error("unknown keyword `{}`", found.0)]
pub(crate) struct UnknownWord {
    pub found: SpannedText,
    pub meant: String,
}

impl Finding for UnknownWord {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let (_, at) = self.found;
        diagnostic
            .label(at, "not a keyword")
            .did_you_mean(at, Some(&self.meant))
    }
}
