use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Agent without a program
///
/// `program(a)` runs the rule that the initial state assigns to the domain of `a`. It assigns none to
/// this domain.
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
#[code(R009, error)]
#[error("agent {agent} has no program {when}")]
pub(crate) struct AgentWithoutProgram {
    pub agent: String,
    pub when: String,
    pub at: Span,
}

impl Finding for AgentWithoutProgram {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "run here")
            .help("add `agent Domain: r_rule[]` for its domain to the default initial state")
    }
}
