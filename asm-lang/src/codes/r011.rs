use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Endless loop
///
/// `while` repeats as long as its guard holds and its body changes something. All loops of a step
/// together may run 10,000,000 times. The message shows what the loop read after some thousand rounds.
///
/// The ranges of `forall`, `choose`, quantifiers and comprehensions together may bind 10,000,000 elements. If the guard of a
/// `forall` or `choose` begins with an equation `f($x) = t`, only the elements that satisfy it count.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = while n >= 0 do n := 1 - n
/// default init s0:
///   function n = 0
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
///   main rule r_Main = while n < 9 do n := n + 1
/// default init s0:
///   function n = 0
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(R011, error)]
#[error("endless loop: {limit} iterations {when}")]
pub(crate) struct EndlessLoop {
    pub limit: u32,
    pub when: String,
    /// `true` for the range of a variable, `false` for a loop that repeats its body.
    pub is_range: bool,
    pub at: Span,
}

impl Finding for EndlessLoop {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        if self.is_range {
            return diagnostic
                .label(self.at, "the elements of this range were bound too often")
                .help(
                    "begin the guard of `forall` or `choose` with an equation `f($x) = t`: the machine then visits only the \
                     elements that satisfy it",
                );
        }
        diagnostic
            .label(self.at, "this loop did not end")
            .help("check that the body makes the guard false")
    }
}
