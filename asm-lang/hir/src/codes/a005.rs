use crate::hidden::HiddenName;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Unknown literal
///
/// A name that starts with a capital is a literal of an enumeration or a domain. No enumeration or
/// domain declares this one.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   enum domain Mode = {IDLE | BUSY}
///   controlled mode: Mode
/// definitions:
///   main rule r_Main = mode := IDEL
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   enum domain Mode = {IDLE | BUSY}
///   controlled mode: Mode
/// definitions:
///   main rule r_Main = mode := IDLE
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A005, error)]
#[error("unknown literal or domain `{name}`")]
pub(crate) struct UnknownConstant {
    pub name: Arc<str>,
    pub at: Span,
    pub similar: Option<Arc<str>>,
    pub hidden: Option<HiddenName>,
}

impl Finding for UnknownConstant {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        if let Some(hidden) = &self.hidden {
            return hidden.explain(diagnostic, self.at);
        }
        diagnostic
            .label(self.at, "not declared in this file or its imports")
            .did_you_mean_or(
                self.at,
                self.similar.as_deref(),
                "declare it as a domain, or as a literal of an `enum domain`",
            )
    }
}
