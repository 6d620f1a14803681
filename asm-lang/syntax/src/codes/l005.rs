use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Not a single character
///
/// Single quotes contain exactly one character. Write a string in double quotes.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled s: String
/// definitions:
///   main rule r_Main = s := 'hello'
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled s: String
/// definitions:
///   main rule r_Main = s := "hello"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L005, error)]
#[error("expected exactly one character between single quotes")]
pub(crate) struct CharLength {
    pub text: String,
    pub at: Span,
}

impl Finding for CharLength {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { text, .. } = self;
        let found = diagnostic.label(self.at, "not a single character");
        if text.is_empty() {
            found
        } else {
            found.guess(
                "write a string in double quotes",
                self.at,
                format!("\"{text}\""),
            )
        }
    }
}
