use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// `agent` outside an initial state
///
/// `agent Domain: r_rule[]` assigns a program to the agents of a domain. It belongs to the initial
/// state, after the functions.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   domain Robot subsetof Agent
///   static rob1: Robot
///   controlled done: Boolean
/// definitions:
///   rule r_work = done := true
///   agent Robot: r_work[]
///   main rule r_Main = program(rob1)
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   domain Robot subsetof Agent
///   static rob1: Robot
///   controlled done: Boolean
/// definitions:
///   rule r_work = done := true
///   main rule r_Main = program(rob1)
/// default init s0:
///   agent Robot: r_work[]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L025, error)]
#[error("`agent` outside an initial state")]
pub(crate) struct AgentOutsideInit {
    pub at: Span,
}

impl Finding for AgentOutsideInit {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "not inside an initial state")
            .help("move it after `default init name:`")
    }
}
