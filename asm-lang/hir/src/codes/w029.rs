use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Asynchronous machine without a scheduler
///
/// All rules called by the main rule run in every step. The main rule of an `asyncr` machine should
/// choose an agent, so that one of them runs at a time.
///
/// ```asm wrong
/// asyncr asm example
/// import StandardLibrary
/// signature:
///   static a: Agent
/// definitions:
///   rule r_work = skip
///   main rule r_Main = forall $a in Agent do program($a)
/// default init s0:
///   agent Agent: r_work[]
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asyncr asm example
/// import StandardLibrary
/// signature:
///   static a: Agent
/// definitions:
///   rule r_work = skip
///   main rule r_Main = choose $a in Agent do program($a)
/// default init s0:
///   agent Agent: r_work[]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(W029, warning)]
#[error("no rule of this `asyncr` specification chooses an agent")]
pub(crate) struct NothingChosen {
    pub at: Span,
}

impl Finding for NothingChosen {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "everything run here runs in every step")
            .note("the main rule is the only scheduler")
            .help("choose the agents that run, as in `choose $a in Agent do program($a)`")
    }
}
