use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Missing closing quote
///
/// A string is written in double quotes, a character in single quotes. Both end on the line on which
/// they start.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled s: String
/// definitions:
///   main rule r_Main = s := "hello
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
#[code(L004, error)]
#[error("missing closing `{quote}`")]
pub(crate) struct OpenQuote {
    pub quote: char,
    pub open: Span,
}

impl Finding for OpenQuote {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { quote, .. } = self;
        diagnostic
            .label(self.open, "starts here and is not closed on this line")
            .help(format!("close it with `{quote}` on the same line"))
    }
}
