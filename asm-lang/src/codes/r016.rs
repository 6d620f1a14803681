use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Value grows without bound
///
/// Values of `Any` may nest 500 levels deep and contain 1,048,576 elements. A value that grows in every
/// step reaches this limit.
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
/// Corrected:
///
/// ```asm corrected
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
#[error("value too large {when}")]
pub(crate) struct UnboundedValue {
    pub when: String,
    pub at: Span,
}

impl Finding for UnboundedValue {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "nested too deeply, or with too many elements")
            .note("values of `Any` nest at most 500 levels and hold at most 1,048,576 elements")
            .help("store the parts in separate locations, or give the location a narrower domain")
    }
}
