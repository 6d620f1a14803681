use asmotion_diagnostics::{Coded, Diagnostic, Finding};

/// No main rule to run
///
/// A module has no main rule, so it has no steps.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   rule r_set = n := 1
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
///   rule r_set = n := 1
///   main rule r_Main = r_set[]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(R015, error)]
#[error("no main rule to run")]
pub(crate) struct NoMainToRun;

impl Finding for NoMainToRun {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic.help("add `main rule r_Main = …`")
    }
}
