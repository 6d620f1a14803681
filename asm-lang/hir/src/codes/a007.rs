use crate::codes::a006::Respelt;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Fix, Span};

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
    /// Spellings of number literals with which the term has the required type, if there are any.
    pub numbers: Vec<Respelt>,
}

impl Finding for TypeMismatch {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            actual,
            expected: wanted,
            because,
            numbers,
            ..
        } = self;
        let finding = diagnostic.label(self.at, format!("expected {wanted}, found {actual}"));
        let finding = match because {
            Some((because, how)) => finding.label(*because, format!("{how} {wanted}")),
            None => finding,
        };
        match (numbers.as_slice(), conversion(wanted, actual)) {
            ([Respelt { at, domain, text }, others @ ..], _) => {
                let numbers = if others.is_empty() {
                    "number"
                } else {
                    "numbers"
                };
                let title = format!("write the {numbers} as {domain}");
                let fix = Fix::sure(title, *at, text.clone());
                let all = |fix: Fix, other: &Respelt| fix.and(other.at, other.text.clone());
                finding.with_fix(others.iter().fold(fix, all))
            }
            ([], Some(help)) => finding.help(help),
            ([], None) => finding.help(format!("write a term of type {wanted}")),
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
