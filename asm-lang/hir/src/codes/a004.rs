use crate::hidden::HiddenName;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Unknown domain
///
/// The domain is declared neither in this file nor in its imports, or the module that declares it
/// does not export it.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled at: Robott -> Integer
///   abstract domain Robot
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
///   abstract domain Robot
///   controlled at: Robot -> Integer
/// definitions:
///   main rule r_Main = skip
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A004, error)]
#[error("unknown domain `{name}`")]
pub(crate) struct UnknownDomain {
    pub name: Arc<str>,
    pub at: Span,
    pub similar: Option<Arc<str>>,
    pub hidden: Option<HiddenName>,
}

impl Finding for UnknownDomain {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        if let Some(hidden) = &self.hidden {
            return hidden.explain(diagnostic, self.at);
        }
        diagnostic
            .label(self.at, "not declared in this file or its imports")
            .did_you_mean_or(
                self.at,
                self.similar.as_deref(),
                "declare it in the signature, or import the module that declares it",
            )
    }
}
