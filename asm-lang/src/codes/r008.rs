use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Wrong number of arguments for a rule value
///
/// A rule stored in a location must be run with one argument for each of its parameters.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled act: Rule(Integer)
///   controlled n: Integer
/// definitions:
///   rule r_set($x in Integer) = n := $x
///   main rule r_Main = act[1, 2]
/// default init s0:
///   function act = <<r_set(Integer)>>
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled act: Rule(Integer)
///   controlled n: Integer
/// definitions:
///   rule r_set($x in Integer) = n := $x
///   main rule r_Main = act[1]
/// default init s0:
///   function act = <<r_set(Integer)>>
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(R008, error)]
#[error("the rule takes {expected} argument{}, not {actual}, {when}", if *expected == 1 { "" } else { "s" })]
pub(crate) struct WrongRuleArity {
    pub expected: u32,
    pub actual: u32,
    pub when: String,
    pub at: Span,
}

impl Finding for WrongRuleArity {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "run here")
            .help("pass one argument for each parameter")
    }
}
