use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Unknown variable
///
/// A variable starts with `$`. It is bound by `let`, `forall`, `choose`, `extend` or a quantifier, or
/// it is a parameter.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n := $x
/// ```
///
/// Mended:
///
/// ```asm mended
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = let ($x = 1) in n := $x endlet
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A002, error)]
#[error("unknown variable `{name}`")]
pub(crate) struct UnknownVariable {
    pub name: Arc<str>,
    pub at: Span,
    pub similar: Option<Arc<str>>,
}

impl Finding for UnknownVariable {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { similar, .. } = self;
        let finding = diagnostic.label(self.at, "not bound here");
        match similar {
            Some(name) => {
                finding.guess(format!("did you mean `{name}`?"), self.at, name.to_string())
            }
            None => finding
                .help("bind it with `let`, `forall`, `choose`, or make it a parameter of the rule"),
        }
    }
}
