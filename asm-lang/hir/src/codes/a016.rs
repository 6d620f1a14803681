use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Update of a static or derived function
///
/// A static function never changes, and a derived function is computed from others. Rules can update
/// `controlled`, `shared` and `out` functions.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   static limit: Integer
/// definitions:
///   function limit = 9
///   main rule r_Main = limit := 8
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled limit: Integer
/// definitions:
///   main rule r_Main = limit := 8
/// default init s0:
///   function limit = 9
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A016, error)]
#[error("`{function}` is {kind}, so no rule may update it")]
pub(crate) struct WritesFixed {
    pub function: Arc<str>,
    pub kind: &'static str,
    pub at: Span,
    pub declared: Span,
}

impl Finding for WritesFixed {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { kind, .. } = self;
        diagnostic
            .label(self.at, "updated here")
            .label(self.declared, format!("declared {kind} here"))
            .help("declare it `controlled` to let rules write it")
    }
}
