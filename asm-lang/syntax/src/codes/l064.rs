use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// End of a rule that has none
///
/// `choose`, `forall`, `while` and `extend` end with the rule in their body. Only `if`, `par`, `seq`,
/// `let`, `switch` and `iterate` have a keyword for their end.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main =
///     choose $x in {1 : 3} with $x > 1 do
///       n := $x
///     endchoose
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
///   main rule r_Main =
///     choose $x in {1 : 3} with $x > 1 do
///       n := $x
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L064, error)]
#[error("`{word}` is not a keyword")]
pub(crate) struct UnneededEnd {
    pub word: String,
    pub at: Span,
    /// The word with the blanks before it, and the line end if it stands alone on its line.
    pub removed: Span,
}

impl Finding for UnneededEnd {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let begin = self.word.trim_start_matches("end");
        diagnostic
            .label(self.at, format!("`{begin}` ends with its rule"))
            .fix(format!("remove `{}`", self.word), self.removed, "")
    }
}
