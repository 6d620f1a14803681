use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Range over an infinite domain
///
/// The elements of Integer, Real or String cannot be enumerated.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled ok: Boolean
/// definitions:
///   main rule r_Main = ok := (forall $x in Integer with $x > 0)
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled ok: Boolean
/// definitions:
///   main rule r_Main = ok := (forall $x in {1 : 9} with $x > 0)
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(R005, error)]
#[error("a variable ranges over an infinite domain {when}")]
pub(crate) struct InfiniteRange {
    pub when: String,
    pub at: Span,
}

impl Finding for InfiniteRange {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "infinitely many elements")
            .help("range over a finite subset, as in `domain Small subsetof Integer` with `domain Small = {0 : 9}`")
    }
}
