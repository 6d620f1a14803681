use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// An input that is missing
///
/// The environment has no answer for a location that the step reads: a script without `[default]` for
/// it, or a binding that has received nothing.
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
/// Mended:
///
/// ```asm mended
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n := 1
/// ```
///
/// In a script, a value under `[default]` answers in every step.
#[derive(Debug, thiserror::Error, Coded)]
#[code(R013, error)]
#[error("no value for `{location}` {when}: {reason}")]
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
            .help("let the environment answer it, or give it a default")
    }
}
