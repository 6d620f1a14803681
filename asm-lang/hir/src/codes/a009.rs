use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Duplicate declaration
///
/// A name can be declared only once, except that functions and rules may share a name if their domains
/// differ.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
///   monitored n: Integer
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
///   controlled n: Integer
///   monitored wish: Integer
/// definitions:
///   main rule r_Main = n := 1
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A009, error)]
#[error("duplicate declaration of `{name}`")]
pub(crate) struct DuplicateDeclaration {
    pub name: Arc<str>,
    pub at: Span,
    pub first: Span,
}

impl Finding for DuplicateDeclaration {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "declared again here")
            .label(self.first, "first declared here")
            .help("rename one of them; functions may share a name if their domains differ")
    }
}
