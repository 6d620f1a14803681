use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Invalid letter in a name
///
/// Names consist of the letters a to z, digits and `_`. A variable begins with `$`, which no name contains. Comments and strings may contain any character.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled größe: Integer
/// definitions:
///   main rule r_Main = größe := 1
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled size: Integer
/// definitions:
///   main rule r_Main = size := 1
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L002, error)]
#[error("invalid letter in the name `{word}`")]
pub(crate) struct ForeignLetters {
    pub word: String,
    pub at: Span,
}

impl Finding for ForeignLetters {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let diagnostic = diagnostic.label(self.at, "invalid name");
        if self.word.is_ascii() {
            return diagnostic
                .help("`$` is the first character of a variable; no name contains it");
        }
        diagnostic.help("use the letters `a` to `z` and `A` to `Z`, digits and `_`")
    }
}
