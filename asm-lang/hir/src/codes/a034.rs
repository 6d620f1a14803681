use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Update of `self` or `program`
///
/// `self` is the agent whose program is running, and `program` the rule it runs. They are set when the
/// program of an agent is run; rules can only read them.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   static a: Agent
///   controlled n: Integer
/// definitions:
///   main rule r_Main = self := a
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   static a: Agent
///   controlled n: Integer
/// definitions:
///   rule r_work = n := 1
///   main rule r_Main = program(a)
/// default init s0:
///   agent Agent: r_work[]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A034, error)]
#[error("`{function}` is set by the machine, so no rule may update it")]
pub(crate) struct WritesReserved {
    pub function: Arc<str>,
    pub at: Span,
}

impl Finding for WritesReserved {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { function, .. } = self;
        diagnostic.label(self.at, "updated here").help(format!(
            "`{function}` is the running agent; run another one with `program(agent)`"
        ))
    }
}
