use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// A value that grows without end
///
/// A value nests at most 500 deep and holds at most 1,048,576 elements. One that grows in every step
/// meets this limit, not the end of the memory.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled x: Any
/// definitions:
///   main rule r_Main =
///     while true do x := [x]
/// default init s0:
///   function x = 1
/// ```
///
/// Mended:
///
/// ```asm mended
/// asm example
/// import StandardLibrary
/// signature:
///   controlled x: Seq(Integer)
/// definitions:
///   main rule r_Main = x := append(x, 1)
/// default init s0:
///   function x = []
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(R016, error)]
#[error("a value grows without end, {when}")]
pub(crate) struct UnboundedValue {
    pub when: String,
    pub at: Span,
}

impl Finding for UnboundedValue {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "it nests too deeply, or holds too much")
            .note("values of `Any` nest 500 deep at most, and hold 1,048,576 elements")
            .help(
                "keep the parts in locations of their own, or give the location a narrower domain",
            )
    }
}
