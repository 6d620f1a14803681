use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Range is not a collection
///
/// When the rule runs, the range is undef or a single value instead of a collection.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled open: Powerset(Integer)
///   controlled n: Integer
/// definitions:
///   main rule r_Main = forall $x in open do n := $x
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled open: Powerset(Integer)
///   controlled n: Integer
/// definitions:
///   main rule r_Main = forall $x in open do n := $x
/// default init s0:
///   function open = {1}
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(R006, error)]
#[error("expected a collection, found {value} {when}")]
pub(crate) struct RangeIsNoCollection {
    pub value: String,
    pub when: String,
    pub at: Span,
}

impl Finding for RangeIsNoCollection {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "expected a set, sequence or bag")
            .help("initialise the location it reads")
    }
}
