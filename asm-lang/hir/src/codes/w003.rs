use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Import without effect
///
/// A module without an `export` clause exports nothing.
///
/// ```asm wrong
/// asm example
/// import other
/// signature:
/// definitions:
///   main rule r_Main = skip
/// //--- other.asm
/// module other
/// signature:
///   static limit: Integer
/// definitions:
///   function limit = 9
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import other
/// signature:
/// definitions:
///   main rule r_Main = skip
/// //--- other.asm
/// module other
/// export *
/// signature:
///   static limit: Integer
/// definitions:
///   function limit = 9
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(W003, warning)]
#[error("`{module}` exports nothing")]
pub(crate) struct ImportsNothing {
    pub module: Arc<str>,
    pub at: Span,
}

impl Finding for ImportsNothing {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "imports no names")
            .help("add `export *` to the module")
    }
}
