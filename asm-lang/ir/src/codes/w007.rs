use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Derived function that never changes
///
/// A derived function depends on the state. This one does not, so it is static. AsmetaS rejects it.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled speed: Integer
///   derived twice: Integer -> Integer
/// definitions:
///   function twice($x in Integer) = $x + $x
///   main rule r_Main = speed := twice(3)
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled speed: Integer
///   static twice: Integer -> Integer
/// definitions:
///   function twice($x in Integer) = $x + $x
///   main rule r_Main = speed := twice(3)
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(W007, warning)]
#[error("`{name}` is derived, but its value never changes")]
pub(crate) struct DerivedNeverChanges {
    pub name: Arc<str>,
    pub declared: Span,
    /// Span of the keyword `derived` in the declaration, which the fix replaces.
    pub keyword: Span,
    /// Span of the definition.
    pub body: Span,
}

impl Finding for DerivedNeverChanges {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.declared, "declared derived here")
            .label(self.body, "does not depend on the state")
            .fix("declare it `static`", self.keyword, "static")
    }
}
