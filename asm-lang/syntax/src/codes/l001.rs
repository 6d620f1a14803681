use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unknown characters
///
/// These characters do not begin any word, number or operator of AsmetaL.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n := 1 # 2
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
///   main rule r_Main = n := 1 + 2
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L001, error)]
#[error("unexpected `{characters}`")]
pub(crate) struct UnknownCharacters {
    pub characters: String,
    pub at: Span,
}

impl Finding for UnknownCharacters {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let diagnostic = diagnostic.label(self.at, "not part of the language");
        if self.characters.starts_with('#') {
            return diagnostic.help("a comment begins with `//`, or is between `/*` and `*/`");
        }
        diagnostic
    }
}
