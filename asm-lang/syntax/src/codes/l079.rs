use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Interval without brackets
///
/// An interval is a set or a sequence: `{1 : 5}` or `[1 : 5]`.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = choose $n in 1..5 with true do n := $n
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
///   main rule r_Main = choose $n in {1 : 5} with true do n := $n
/// default init s0:
///   function n = 1
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L079, error)]
#[error("an interval needs brackets")]
pub(crate) struct BareInterval {
    pub at: Span,
}

impl Finding for BareInterval {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "interval without brackets")
            .help("write `{1 : 5}` for a set, or `[1 : 5]` for a sequence")
    }
}
