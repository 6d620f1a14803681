use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Static function that changes
///
/// A static function has the same value in every state. This one depends on the state, so it is
/// derived. AsmetaS rejects it.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled speed: Integer
///   static fast: Boolean
/// definitions:
///   function fast = speed > 5
///   main rule r_Main = if fast then speed := 0 endif
/// default init s0:
///   function speed = 9
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled speed: Integer
///   derived fast: Boolean
/// definitions:
///   function fast = speed > 5
///   main rule r_Main = if fast then speed := 0 endif
/// default init s0:
///   function speed = 9
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(W006, warning)]
#[error("`{name}` is static, but its value may change")]
pub(crate) struct StaticChanges {
    pub name: Arc<str>,
    pub declared: Span,
    /// Span of the keyword `static` in the declaration, which the fix replaces.
    pub keyword: Span,
    /// Span of the first part that depends on the state, if one can be named.
    pub at: Option<Span>,
}

impl Finding for StaticChanges {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let diagnostic = diagnostic.label(self.declared, "declared static here");
        let diagnostic = match self.at {
            Some(at) => diagnostic.label(at, "may change from step to step"),
            None => diagnostic,
        };
        diagnostic.fix("declare it `derived`", self.keyword, "derived")
    }
}
