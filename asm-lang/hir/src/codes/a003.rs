use crate::hidden::HiddenName;
use crate::suggest::with_similar;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Unknown rule
///
/// The rule is declared neither in this file nor in its imports, or the module that declares it does
/// not export it.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   rule r_set = n := 1
///   main rule r_Main = r_sett[]
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
///   rule r_set = n := 1
///   main rule r_Main = r_set[]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A003, error)]
#[error("unknown rule `{name}`")]
pub(crate) struct UnknownRule {
    pub name: Arc<str>,
    pub at: Span,
    pub similar: Option<(Arc<str>, Span)>,
    pub hidden: Option<HiddenName>,
}

impl Finding for UnknownRule {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { similar, .. } = self;
        if let Some(hidden) = &self.hidden {
            return hidden.explain(diagnostic, self.at);
        }
        let finding = diagnostic.label(self.at, "not declared in this file or its imports");
        with_similar(
            finding,
            self.at,
            similar,
            "declare it under `definitions:`, or import the module that declares it",
        )
    }
}
