use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Invalid answer of a partner
///
/// A partner answers an operation with a reply of the right type or with a fault, a number of steps
/// later.
///
/// ```asm
/// asm example
/// import StandardLibrary
/// import CommonBehavior
/// signature:
///   domain Planner subsetof Agent
///   static planner: Planner
///   out plan: Prod(Agent, Integer) -> Integer
///   controlled length: Integer
/// definitions:
///   main rule r_Main = r_wcall[planner, "plan", 7, 2000, length]
/// ```
///
/// ```toml wrong
/// [partner.planner]
/// plan = { reply = "soon" }
/// ```
///
/// Corrected:
///
/// ```toml corrected
/// [partner.planner]
/// plan = { reply = 3, after = 2 }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(S005, error)]
#[error("invalid reply of a partner")]
pub(crate) struct NotAnAnswer {
    pub at: Span,
}

impl Finding for NotAnAnswer {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "expected a reply that matches the operation, or a fault")
            .help("write `{ reply = …, after = 2 }` or `{ fault = \"CALL_TIMEOUT\" }`; other faults are `CALL_UNAVAILABLE`, `CALL_FAILED` and `CALL_CANCELLED`; `after` counts steps from 1")
    }
}
