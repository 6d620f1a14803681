use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Assumptions that no initial state satisfies
///
/// An assumption (`INVAR`, `--assume`, an invariant about inputs alone) leaves only the states and inputs to consider in which it is
/// true. If it is false in the initial state with all inputs, nothing is left, and every property would hold.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled isOn: Boolean
/// definitions:
///   INVAR isOn
///   main rule r_Main = isOn := not isOn
/// default init s0:
///   function isOn = false
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled isOn: Boolean
/// definitions:
///   main rule r_Main = isOn := not isOn
/// default init s0:
///   function isOn = false
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(M006, error)]
#[error("the assumptions exclude the initial state")]
pub(crate) struct NothingAssumed {
    /// Texts of the assumptions.
    pub assumptions: Vec<String>,
    pub at: Span,
}

impl Finding for NothingAssumed {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let assumed = self.assumptions.join("`, `");
        diagnostic
            .label(self.at, "no run of this rule is left to consider")
            .note(format!("assumed: `{assumed}`"))
            .help("weaken the assumptions, or change the initial state")
    }
}
