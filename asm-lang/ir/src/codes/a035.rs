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
/// Mended:
///
/// ```asm mended
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
#[error("the elements of `{domain}` depend on themselves")]
pub(crate) struct CircularDomain {
    pub domain: Arc<str>,
    pub at: Span,
    pub declared: Span,
}

impl Finding for CircularDomain {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "this needs the elements of the domain itself")
            .label(self.declared, "declared here")
            .help("define it by its elements, or by those of another domain")
    }
}
