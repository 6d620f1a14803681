use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Circular subset
///
/// A chain of `subsetof` must end at a basic or abstract domain.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   domain Small subsetof Tiny
///   domain Tiny subsetof Small
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
///   domain Small subsetof Integer
///   domain Tiny subsetof Small
/// definitions:
///   domain Small = {0 : 9}
///   domain Tiny = {0 : 3}
///   main rule r_Main = skip
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A033, error)]
#[error("`{domain}` is a subset of itself")]
pub(crate) struct DomainCycle {
    pub domain: Arc<str>,
    pub at: Span,
}

impl Finding for DomainCycle {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "its `subsetof` leads back to itself")
            .help("declare one of the domains as a subset of a basic or abstract domain")
    }
}
