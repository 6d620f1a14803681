use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Undefined guard
///
/// A guard must be true or false. `undef` propagates: a comparison with an undef operand is undef,
/// except `=` and `!=`.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = if n > 3 then n := 0 endif
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
///   main rule r_Main = if isDef(n) and n > 3 then n := 0 endif
/// ```
///
/// Alternatively, initialise the location in `default init`.
#[derive(Debug, thiserror::Error, Coded)]
#[code(R003, error)]
#[error("undefined guard {when}")]
pub(crate) struct UndefinedGuard {
    pub when: String,
    pub at: Span,
}

impl Finding for UndefinedGuard {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "evaluates to `undef`")
            .note("`undef` propagates: a comparison with an undef operand is undef, except for `=` and `!=`")
            .help("initialise the locations it reads, or test them with `isDef(…)` first")
    }
}
