use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Old spelling `exist`
///
/// Since AsmetaS 26.06 the keyword is `exists`. Both are accepted; `asmotion check --fix` replaces the
/// old one.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled ok: Boolean
/// definitions:
///   main rule r_Main = ok := (exist $x in {1 : 3} with $x > 2)
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
///   main rule r_Main = ok := (exists $x in {1 : 3} with $x > 2)
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L070, warning)]
#[error("deprecated keyword `exist`")]
pub(crate) struct OldExists {
    pub at: Span,
}

impl Finding for OldExists {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "renamed to `exists` in AsmetaS 26.06")
            .fix("write `exists`", self.at, "exists")
    }
}
