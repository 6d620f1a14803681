use crate::edits::all_sure;
use asmotion_diagnostics::{Coded, Diagnostic, Edit, Finding, Span};

/// Missing heading of a section
///
/// `signature:` starts the declarations and `definitions:` the rules. AsmetaS requires both, even if
/// nothing follows.
///
/// ```asm wrong
/// asm example
/// signature:
///   controlled n: Integer
///   main rule r_Main = n := 1
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n := 1
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L074, warning)]
#[error("missing `{section}:` before {what}")]
pub(crate) struct NoSection {
    pub section: &'static str,
    pub what: &'static str,
    pub at: Span,
    /// Edit that inserts the heading.
    pub written: Edit,
}

impl Finding for NoSection {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { written, .. } = self;
        diagnostic
            .label(self.at, "AsmetaS requires the heading before this")
            .with_fix(all_sure("add the heading", std::slice::from_ref(written)))
    }
}
