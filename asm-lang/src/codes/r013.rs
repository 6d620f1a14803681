use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Missing input
///
/// The step reads a location for which the environment has no value: the script has no `[default]` for
/// it, or its binding has received nothing yet.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   monitored wish: Integer
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n := wish
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
///   main rule r_Main = n := 1
/// ```
///
/// A value under `[default]` applies to every step of a script.
#[derive(Debug, thiserror::Error, Coded)]
#[code(R013, error)]
#[error("missing value for `{location}` {when}: {reason}")]
pub(crate) struct NoInputValue {
    pub location: String,
    pub reason: String,
    pub when: String,
    pub at: Span,
}

impl Finding for NoInputValue {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "read here")
            .help("set it in the environment, or give it a default")
    }
}
