use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Old spelling `..`
///
/// Intervals are written with a colon. Both are accepted; `asmotion check --fix` replaces the dots.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   domain Small subsetof Integer
///   controlled n: Small
/// definitions:
///   domain Small = {1..3}
///   main rule r_Main = n := 2
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   domain Small subsetof Integer
///   controlled n: Small
/// definitions:
///   domain Small = {1 : 3}
///   main rule r_Main = n := 2
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L071, warning)]
#[error("deprecated interval `..`")]
pub(crate) struct OldInterval {
    pub at: Span,
    /// The colon, with blanks if it needs them.
    pub new: &'static str,
}

impl Finding for OldInterval {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "AsmetaS rejects this spelling")
            .fix("write `:`", self.at, self.new)
    }
}
