use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
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
    /// A number argument that fits if it is written as a number of another domain.
    pub number: Option<Respelt>,
}

impl Finding for NoOverload {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            at, hint, number, ..
        } = self;
        let mut finding = diagnostic.label(*at, "applied here");
        for (signature, declared) in self.candidates.iter().take(4) {
            finding = finding.label(*declared, signature.clone());
        }
        match (number, hint) {
            (Some(Respelt { at, domain, text }), _) => {
                finding.fix(format!("write the number as {domain}"), *at, text.clone())
            }
            (None, Some(hint)) => finding.help(hint.clone()),
            (None, None) => {
                finding.help("pass arguments of the declared domains, or declare an overload")
            }
        }
    }
}

/// A replacement for a number literal: its spelling in the required domain.
#[derive(Debug)]
pub(crate) struct Respelt {
    pub at: Span,
    pub domain: &'static str,
    pub text: String,
}
