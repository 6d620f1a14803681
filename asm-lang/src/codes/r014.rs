use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Invariant violated
///
/// An invariant must hold in every state. An invariant that reads inputs is an assumption about them
/// and is checked before the step, as is a constraint (`INVAR`) that reads inputs. Any other invariant is checked after the step,
/// and the message shows the updates that led to the state. A condition that is undef is violated.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   invariant inv_small over n: n < 3
///   main rule r_Main = n := n + 1
/// default init s0:
///   function n = 2
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   invariant inv_small over n: n < 3
///   main rule r_Main = if n < 2 then n := n + 1 endif
/// default init s0:
///   function n = 2
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(R014, error)]
#[error("the {} `{name}` {} {when}", if *is_constraint { "constraint" } else { "invariant" }, if *is_undef { "is undef" } else { "does not hold" })]
pub(crate) struct InvariantViolated {
    pub name: String,
    pub is_undef: bool,
    /// `true` for an assumption about inputs, which is checked before the step.
    pub assumes: bool,
    /// `true` for a constraint (`INVAR`).
    pub is_constraint: bool,
    pub step: u64,
    pub when: String,
    pub at: Span,
}

impl Finding for InvariantViolated {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let help = match (self.is_undef, self.assumes, self.step) {
            (true, ..) => "initialise the locations it reads, or test them with `isDef(…)` first",
            (false, true, _) => "check the inputs of the step, which violate this assumption",
            (false, false, 0) => "change the initial values to satisfy it",
            (false, false, _) => "find the rule that broke it among the updates of the step",
        };
        let diagnostic = diagnostic.label(self.at, "evaluated here").help(help);
        if self.is_constraint {
            diagnostic.note("what was verified under this constraint need not hold in this run")
        } else {
            diagnostic
        }
    }
}
