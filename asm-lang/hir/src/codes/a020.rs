use crate::hidden::HiddenName;
use crate::suggest::with_similar;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Definition without a declaration
///
/// A function or domain that is defined under `definitions:` or in an initial state must be declared in
/// the signature.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = skip
/// default init s0:
///   function m = 1
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
///   main rule r_Main = skip
/// default init s0:
///   function n = 1
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A020, error)]
#[error("`{name}` is defined but not declared")]
pub(crate) struct DefinesUndeclared {
    pub name: Arc<str>,
    pub at: Span,
    pub similar: Option<(Arc<str>, Span)>,
    pub hidden: Option<HiddenName>,
}

impl Finding for DefinesUndeclared {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { similar, .. } = self;
        if let Some(hidden) = &self.hidden {
            return hidden.explain(diagnostic, self.at);
        }
        let finding = diagnostic.label(self.at, "defined here");
        with_similar(finding, self.at, similar, "declare it in the signature")
    }
}
