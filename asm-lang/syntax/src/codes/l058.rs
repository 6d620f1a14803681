use crate::edits::SpannedText;
use crate::lexer::Keyword;
use asmotion_diagnostics::{Coded, Diagnostic, Finding};

/// Unexpected token
///
/// This token does not fit the text before it. The message shows what is expected.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled at: Integer Integer
/// definitions:
///   main rule r_Main = skip
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
///   main rule r_Main = skip
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L058, error)]
#[error("expected {what}, found `{}`", found.0)]
pub(crate) struct UnexpectedToken {
    pub what: String,
    pub found: SpannedText,
    pub after: Option<SpannedText>,
    pub open: Option<SpannedText>,
}

impl Finding for UnexpectedToken {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            what,
            found,
            after,
            open,
        } = self;
        let mut expected = diagnostic.label(found.1, "unexpected");
        if let Some((_, span)) = after {
            expected = expected.label(*span, format!("expected {what} after this"));
        }
        if let Some((word, span)) = open {
            expected = expected.label(*span, format!("inside this `{word}`"));
        }
        if after.is_none() && Keyword::spelled(&found.0).is_some() {
            expected = expected.note(format!("`{}` is a reserved word", found.0));
        }
        expected
    }
}
