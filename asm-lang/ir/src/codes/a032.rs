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
/// Corrected:
///
/// ```asm corrected
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
#[error("expected a location for parameter `{parameter}` of `{rule}`, which updates it")]
pub(crate) struct NotALocation {
    pub rule: Arc<str>,
    pub parameter: String,
    pub at: Span,
    pub declared: Span,
}

impl Finding for NotALocation {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "not a location")
            .label(self.declared, "declared here")
            .help("pass a controlled function with its arguments")
    }
}
