use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Domain cannot be extended
///
/// `extend` creates new elements of abstract domains and their subsets. The elements of other domains,
/// such as numbers and literals, are fixed.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   enum domain Mode = {IDLE | BUSY}
/// definitions:
///   main rule r_Main = extend Mode with $x do skip
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   abstract domain Robot
/// definitions:
///   main rule r_Main = extend Robot with $x do skip
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A026, error)]
#[error("cannot extend `{domain}`: it is {kind}")]
pub(crate) struct CannotExtend {
    pub domain: Arc<str>,
    pub kind: &'static str,
    pub at: Span,
    pub declared: Span,
}

impl Finding for CannotExtend {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { kind, .. } = self;
        diagnostic
            .label(self.at, "extended here")
            .label(self.declared, format!("{kind}, declared here"))
            .help("extend an abstract domain, or a subset of one")
    }
}
