use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Real location that grows in every step
///
/// A location of `Real` may take finitely many values only, since each value is a state of its own. If every step adds a constant to it,
/// whatever the inputs and choices are, the exploration would not end. This is seen before the exploration if the update is the only one
/// of the location and no guard surrounds it; other locations that take ever new values are named when the exploration reaches a limit.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   monitored hot: Boolean
///   controlled elapsed: Real
///   controlled alarm: Boolean
/// definitions:
///   main rule r_Main = par
///     elapsed := elapsed + 0.5
///     alarm := hot and elapsed > 2.0
///   endpar
/// default init s0:
///   function elapsed = 0.0
/// ```
///
/// Corrected: the value has a bound, beyond which it does not matter.
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   monitored hot: Boolean
///   controlled elapsed: Real
///   controlled alarm: Boolean
/// definitions:
///   main rule r_Main = par
///     if elapsed <= 2.0 then elapsed := elapsed + 0.5 endif
///     alarm := hot and elapsed > 2.0
///   endpar
/// default init s0:
///   function elapsed = 0.0
/// ```
///
/// Instead of a bound, `asmotion verify --bound 20` explores a number of steps, and `--states N` a number of states.
#[derive(Debug, thiserror::Error, Coded)]
#[code(M014, error)]
#[error("`{function}` takes a new value in every step")]
pub(crate) struct SteadyGrowth {
    pub function: String,
    /// Place of the update that adds a constant in every step.
    pub at: Span,
    pub declared: Span,
}

impl Finding for SteadyGrowth {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "the only update of it, in each step")
            .label(self.declared, "declared here")
            .help(format!(
                "guard the update, so that `{}` has finitely many values, or explore a number of steps with `--bound`",
                self.function
            ))
    }
}
