use crate::edits::all_sure;
use asmotion_diagnostics::{Coded, Diagnostic, Edit, Finding, Span};

/// Declarations out of order
///
/// AsmetaS requires domains before functions, functions before rules, rules before invariants,
/// invariants before the main rule, and initial states last. asmotion accepts any order; `asmotion
/// check --fix` moves late declarations together with the comments above them.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled mode: Mode
///   enum domain Mode = {IDLE | BUSY}
/// definitions:
///   main rule r_Main = mode := IDLE
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   enum domain Mode = {IDLE | BUSY}
///   controlled mode: Mode
/// definitions:
///   main rule r_Main = mode := IDLE
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L073, warning)]
#[error("{what} after {before}")]
pub(crate) struct OutOfOrder {
    pub what: &'static str,
    pub before: &'static str,
    pub at: Span,
    pub earlier: Span,
    /// Edits that move the declaration; empty if there is no simple fix.
    pub moved: Vec<Edit>,
}

impl Finding for OutOfOrder {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let found = diagnostic
            .label(self.at, "AsmetaS requires this first")
            .label(self.earlier, "and this after it");
        match self.moved.as_slice() {
            [] => found.help("move it before the other declaration"),
            edits => found.with_fix(all_sure("move it before the other declaration", edits)),
        }
    }
}
