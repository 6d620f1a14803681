use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Circular domain definition
///
/// The elements of a domain must be known before those of the domains that are defined by them.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   domain Small subsetof Integer
///   domain Tiny subsetof Integer
/// definitions:
///   domain Small = {$x in Tiny | $x > 1: $x}
///   domain Tiny = {$x in Small | $x < 9: $x}
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
///   domain Tiny subsetof Integer
/// definitions:
///   domain Small = {0 : 99}
///   domain Tiny = {$x in Small | $x < 9: $x}
///   main rule r_Main = skip
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A035, error)]
#[error("circular definition of domain `{domain}`")]
pub(crate) struct CircularDomain {
    pub domain: Arc<str>,
    pub at: Span,
    pub declared: Span,
}

impl Finding for CircularDomain {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "depends on the elements of this domain")
            .label(self.declared, "declared here")
            .help("list its elements, or use the elements of another domain")
    }
}
