use crate::codes::a006::Respelt;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Parts of different domains
///
/// The branches of a conditional term must have the same domain, and so must the elements of a
/// collection.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n := size({1, "two"})
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
///   main rule r_Main = n := size({1, 2})
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A019, error)]
#[error("mismatched types: {what} are {first} and {second}")]
pub(crate) struct DisagreeingDomains {
    pub what: &'static str,
    pub first: String,
    pub second: String,
    /// An integer literal among them, written as a number of the other type.
    pub number: Option<Respelt>,
    pub first_at: Span,
    pub second_at: Span,
}

impl Finding for DisagreeingDomains {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { first, second, .. } = self;
        let diagnostic = diagnostic
            .label(self.second_at, format!("has type {second}"))
            .label(self.first_at, format!("has type {first}"));
        match &self.number {
            Some(Respelt { at, domain, text }) => {
                diagnostic.fix(format!("write the number as {domain}"), *at, text.clone())
            }
            None => diagnostic.help(match (first.as_str(), second.as_str()) {
                ("Integer", "Real") | ("Real", "Integer") => {
                    "write whole numbers with a point, as in `1.0`, or convert them with `itor(…)`"
                }
                _ => "use terms of one domain",
            }),
        }
    }
}
