use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Construct that the symbolic engine cannot represent
///
/// The symbolic engine represents each location by bits, so every location must have finitely many values, and the locations must be
/// known before the run. It does not verify specifications that create elements or locations during the run, that have rules with
/// local functions, or that exchange messages. A location without a finite domain is accepted if its updates yield few values.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   abstract domain Job
///   controlled jobs: Integer
/// definitions:
///   main rule r_Main = extend Job with $job do jobs := 1
/// default init s0:
///   function jobs = 0
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   enum domain Job = {NONE | CLEAN | FETCH}
///   controlled job: Job
/// definitions:
///   main rule r_Main = choose $job in Job with true do job := $job
/// default init s0:
///   function job = NONE
/// ```
///
/// The explicit engine has no such restrictions: `asmotion verify --engine explicit`, which is the default.
#[derive(Debug, thiserror::Error, Coded)]
#[code(M030, error)]
#[cfg_attr(
    not(feature = "symbolic"),
    allow(dead_code, reason = "the symbolic engine is a feature")
)]
#[error("the symbolic engine cannot represent {construct}")]
pub(crate) struct NotSymbolic {
    pub construct: String,
    pub at: Span,
}

impl Finding for NotSymbolic {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "here")
            .help("use the explicit engine: `--engine explicit`, which is the default")
    }
}
