use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Properties that a run does not check
///
/// Temporal properties (`CTLSPEC`, `LTLSPEC`), their fairness constraints (`JUSTICE`, `COMPASSION`) and constraints about the state
/// alone (`INVAR`) are about all runs, so a single run does not check them: it behaves as if they were not there, even if they are
/// false. `asmotion verify` proves or refutes them. A constraint that reads inputs is checked in every step, like an invariant.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// import CTLLibrary
/// signature:
///   controlled moving: Boolean
///   monitored permit: Boolean
/// definitions:
///   main rule r_Main = moving := permit
///   CTLSPEC ag(moving implies permit)
/// default init s0:
///   function moving = false
/// ```
///
/// An invariant is checked in every state of a run:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled moving: Boolean
///   controlled permitted: Boolean
/// definitions:
///   invariant over moving, permitted: moving implies permitted
///   main rule r_Main = moving := permitted
/// default init s0:
///   function moving = false
///   function permitted = false
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(W031, warning)]
#[error("{}, which runs do not check", properties(*count))]
pub(crate) struct PropertiesNotVerified {
    pub count: usize,
    /// The first property.
    pub at: Span,
}

fn properties(count: usize) -> String {
    match count {
        1 => "1 temporal property".to_owned(),
        _ => format!("{count} temporal properties"),
    }
}

impl Finding for PropertiesNotVerified {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let first = if self.count == 1 {
            "not checked"
        } else {
            "the first of them"
        };
        diagnostic
            .label(self.at, first)
            .note("a run checks invariants, and constraints (`INVAR`) that read inputs; `asmotion verify` proves temporal properties, or shows a run that violates them")
    }
}
