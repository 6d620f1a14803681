use crate::codes::a006::Respelt;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Type mismatch
///
/// The term belongs to another domain than the one required here. Integer, Natural and Real are
/// different domains; functions such as `itor` and `rtoi` convert between them.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled x: Real
/// definitions:
///   main rule r_Main = x := 1
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled x: Real
/// definitions:
///   main rule r_Main = x := 1.0
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A007, error)]
#[error("mismatched types: expected {expected} for {what}, found {actual}")]
pub(crate) struct TypeMismatch {
    pub what: String,
    pub expected: String,
    pub actual: String,
    pub at: Span,
    /// Span that determines the required type, with the beginning of its label.
    pub because: Option<(Span, &'static str)>,
    /// Spelling of a number literal in the required domain, if it has one.
    pub number: Option<Respelt>,
}

impl Finding for TypeMismatch {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            actual,
            expected: wanted,
            because,
            number,
            ..
        } = self;
        let finding = diagnostic.label(self.at, format!("expected {wanted}, found {actual}"));
        let finding = match because {
            Some((because, how)) => finding.label(*because, format!("{how} {wanted}")),
            None => finding,
        };
        match (number, conversion(wanted, actual)) {
            (Some(Respelt { at, text, .. }), _) => {
                finding.fix(format!("write the number as {wanted}"), *at, text.clone())
            }
            (None, Some(help)) => finding.help(help),
            (None, None) => finding.help(format!("write a term of type {wanted}")),
        }
    }
}

/// Returns a suggestion for the standard function that converts between the types.
fn conversion(expected: &str, actual: &str) -> Option<String> {
    let function = match (actual, expected) {
        ("Integer", "Real") => "itor",
        ("Integer", "Natural") => "iton",
        ("Natural", "Real") => "ntor",
        ("Natural", "Integer") => "ntoi",
        ("Real", "Integer") => "rtoi",
        ("Real", "Natural") => "rton",
        (_, "String") => "toString",
        _ => return None,
    };
    Some(format!("convert it with `{function}(…)`"))
}
