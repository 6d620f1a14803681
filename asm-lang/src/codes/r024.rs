use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// No inputs satisfy a constraint
///
/// A random simulation draws inputs for which the constraints (`INVAR`) of the specification hold, because verification considers no
/// others. In this state there are none among the values that it draws: truth values, elements of finite domains, numbers from −100
/// to 100. A script (`--env`) can give other values. Verification leaves out a state without inputs that satisfy the constraints.
///
/// ```asm random wrong
/// asm example
/// import StandardLibrary
/// import CTLLibrary
/// signature:
///   monitored request: Boolean
///   controlled served: Boolean
/// definitions:
///   INVAR request = served and request != served
///   main rule r_Main = served := request
/// default init s0:
///   function served = false
/// ```
///
/// Corrected:
///
/// ```asm random corrected
/// asm example
/// import StandardLibrary
/// import CTLLibrary
/// signature:
///   monitored request: Boolean
///   controlled served: Boolean
/// definitions:
///   INVAR request != served
///   main rule r_Main = served := request
/// default init s0:
///   function served = false
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(R024, error)]
#[error("no inputs satisfy the constraint{} {names} {when}", if *are_several { "s" } else { "" })]
pub(crate) struct NoConstrainedInputs {
    /// The constraints that did not hold, separated by commas.
    pub names: String,
    pub are_several: bool,
    /// `true` if all values that can be drawn were tried.
    pub is_exhaustive: bool,
    pub when: String,
    pub at: Span,
}

impl Finding for NoConstrainedInputs {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let help = if self.is_exhaustive {
            "weaken the constraint, or change the rules so that this state is not reached"
        } else {
            "give the inputs in a script (`--env`)"
        };
        diagnostic.label(self.at, "evaluated here").help(help)
    }
}
