use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// One `endif` for `else if`
///
/// `else if` starts a nested `if` inside the `else`, and each of them needs an `endif`.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main =
///     if n = 1 then n := 2
///     else if n = 2 then n := 3
///     endif
///   rule r_other = skip
/// default init s0:
///   function n = 1
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
///   rule r_other = skip
///   main rule r_Main =
///     if n = 1 then n := 2
///     else if n = 2 then n := 3 endif
///     endif
/// default init s0:
///   function n = 1
/// ```
///
/// `switch n case 1: … case 2: … endswitch` has only one end.
#[derive(Debug, thiserror::Error, Coded)]
#[code(L032, error)]
#[error("missing `endif` after `else if`")]
pub(crate) struct UnclosedElseIf {
    pub at: Span,
    pub outer: Span,
    pub inner: Span,
}

impl Finding for UnclosedElseIf {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "expected another `endif` before this")
            .label(self.outer, "unclosed `if`")
            .label(self.inner, "this `if` needs its own `endif`")
            .help("close both: `if … else if … endif endif`")
    }
}
