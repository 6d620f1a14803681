use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Domain without elements
///
/// A subset of Integer or of an enumeration contains only the elements of its definition. Without a
/// definition it is empty, so every update with a value of it fails.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   domain Speed subsetof Integer
///   controlled speed: Speed
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
///   domain Speed subsetof Integer
///   controlled speed: Speed
/// definitions:
///   domain Speed = {0 : 9}
///   main rule r_Main = speed := 3
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(W004, warning)]
#[error("domain `{domain}` has no elements")]
pub(crate) struct EmptyDomain {
    pub domain: Arc<str>,
    pub at: Span,
}

impl Finding for EmptyDomain {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { domain, .. } = self;
        diagnostic
            .label(self.at, "declared here, but not defined")
            .help(format!(
                "add `domain {domain} = {{…}}` under `definitions:`"
            ))
    }
}
