use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Value instead of a location
///
/// A macro that updates its parameter must be called with a location.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   rule r_set($x in Integer) = $x := 1
///   main rule r_Main = r_set[n + 1]
/// default init s0:
///   function n = 0
/// ```
///
/// Mended:
///
/// ```asm mended
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   rule r_set($x in Integer) = $x := 1
///   main rule r_Main = r_set[n]
/// default init s0:
///   function n = 0
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A032, error)]
#[error("`{rule}` updates its parameter `{parameter}`, so it needs a location")]
pub(crate) struct NotALocation {
    pub rule: Arc<str>,
    pub parameter: String,
    pub at: Span,
    pub declared: Span,
}

impl Finding for NotALocation {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "this is a value")
            .label(self.declared, "declared here")
            .help("pass a controlled function, applied to its arguments")
    }
}
