use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Message does not fit the operation
///
/// The data of a message must belong to the domain of the operation, and its reply to the codomain.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// import CommonBehavior
/// signature:
///   domain Planner subsetof Agent
///   static planner: Planner
///   out plan: Prod(Agent, Integer) -> Integer
/// definitions:
///   main rule r_Main = r_wsend[planner, "plan", "kitchen"]
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// import CommonBehavior
/// signature:
///   domain Planner subsetof Agent
///   static planner: Planner
///   out plan: Prod(Agent, Integer) -> Integer
/// definitions:
///   main rule r_Main = r_wsend[planner, "plan", 3]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A041, error)]
#[error("mismatched types: {expectation}, found {actual}")]
pub(crate) struct MessageMismatch {
    /// First part of the message: the required domain and its position.
    pub expectation: String,
    pub actual: String,
    pub at: Span,
    pub declared: Span,
}

impl Finding for MessageMismatch {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, format!("has type {}", self.actual))
            .label(self.declared, "the operation is declared here")
            .help("pass what the operation declares, or change its declaration for all partners")
    }
}
