use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Extension of a domain that is not dynamic
///
/// `extend` creates elements, so the domain changes between steps. AsmetaS requires `dynamic` in its
/// declaration.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   abstract domain Robot
/// definitions:
///   main rule r_Main = extend Robot with $x do skip
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   dynamic abstract domain Robot
/// definitions:
///   main rule r_Main = extend Robot with $x do skip
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(W027, warning)]
#[error("`{domain}` is extended, but not declared `dynamic`")]
pub(crate) struct ExtendsStatic {
    pub domain: Arc<str>,
    pub at: Span,
    pub declared: Span,
}

impl Finding for ExtendsStatic {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "extended here")
            .label(self.declared, "declared here")
            .help("write `dynamic` before the declaration; the reference tools require it")
    }
}
