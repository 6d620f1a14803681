use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// An `asyncr` machine that chooses no agent
///
/// There is no scheduler but the main rule: what it runs, runs in every step. A main rule that chooses
/// an agent lets one run at a time.
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
/// Mended:
///
/// ```asm mended
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
#[error("the specification is `asyncr`, but nothing chooses who runs")]
pub(crate) struct NothingChosen {
    pub at: Span,
}

impl Finding for NothingChosen {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "all that this runs, runs in every step")
            .note("there is no scheduler but the main rule")
            .help("choose the agents that run, as in `choose $a in Agent do program($a)`")
    }
}
