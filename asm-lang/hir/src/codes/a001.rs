use crate::suggest::with_similar;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Unknown function
///
/// The function is declared neither in this file nor in its imports.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled speed: Integer
/// definitions:
///   main rule r_Main = sped := 1
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled speed: Integer
/// definitions:
///   main rule r_Main = speed := 1
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A001, error)]
#[error("unknown function `{name}`")]
pub(crate) struct UnknownFunction {
    pub name: Arc<str>,
    pub at: Span,
    pub similar: Option<(Arc<str>, Span)>,
}

impl Finding for UnknownFunction {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { similar, .. } = self;
        let finding = diagnostic.label(self.at, "not declared in this file or its imports");
        let help = "declare it in the signature, or import the module that declares it";
        with_similar(finding, self.at, similar, help)
    }
}
