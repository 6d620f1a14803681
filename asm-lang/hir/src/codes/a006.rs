use crate::codes::w001::negated;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Fix, Span};
use std::sync::Arc;

/// No matching declaration of a function
///
/// A function may be declared several times with different domains. None of its declarations accepts
/// these arguments.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n := n + "1"
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
///   main rule r_Main = n := n + 1
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A006, error)]
#[error("no declaration of `{name}` takes {actual}")]
pub(crate) struct NoOverload {
    pub name: Arc<str>,
    pub at: Span,
    pub actual: String,
    pub candidates: Vec<(String, Span)>,
    pub hint: Option<String>,
    /// Number arguments that fit if they are written as numbers of another domain.
    pub numbers: Vec<Respelt>,
    /// The comparison behind a `not` that was meant to negate it.
    pub comparison: Option<Span>,
}

impl Finding for NoOverload {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            at, hint, numbers, ..
        } = self;
        let mut finding = diagnostic.label(*at, "applied here");
        for (signature, declared) in self.candidates.iter().take(4) {
            finding = finding.label(*declared, signature.clone());
        }
        if let Some(comparison) = self.comparison {
            return finding.with_fix(negated(comparison));
        }
        match (numbers.as_slice(), hint) {
            ([Respelt { at, domain, text }, others @ ..], _) => {
                let title = match others {
                    [] => format!("write the number as {domain}"),
                    _ => "write the numbers as the declaration requires".to_owned(),
                };
                let fix = Fix::sure(title, *at, text.clone());
                let all = |fix: Fix, other: &Respelt| fix.and(other.at, other.text.clone());
                finding.with_fix(others.iter().fold(fix, all))
            }
            ([], Some(hint)) => finding.help(hint.clone()),
            ([], None) => {
                finding.help("pass arguments of the declared domains, or declare an overload")
            }
        }
    }
}

/// A replacement for a number literal: its spelling in the required domain.
#[derive(Debug, Clone)]
pub(crate) struct Respelt {
    pub at: Span,
    pub domain: &'static str,
    pub text: String,
}

impl Respelt {
    /// Returns the number domain with this name.
    pub fn domain(name: &str) -> Option<&'static str> {
        let mut domains = ["Real", "Natural", "Integer"].into_iter();
        domains.find(|domain| *domain == name)
    }
}
