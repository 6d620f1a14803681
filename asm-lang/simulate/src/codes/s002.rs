use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unknown table in a script
///
/// Inputs are given under `[default]` for all steps, or under one `[[step]]` per step.
///
/// ```asm
/// asm example
/// import StandardLibrary
/// signature:
///   enum domain Mode = {IDLE | BUSY}
///   monitored mode: Mode
///   monitored speed: Integer
///   controlled n: Integer
/// definitions:
///   main rule r_Main = if mode = BUSY then n := speed endif
/// ```
///
/// ```toml wrong
/// [defaults]
/// speed = 3
/// ```
///
/// Corrected:
///
/// ```toml corrected
/// [default]
/// speed = 3
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(S002, error)]
#[error("expected `[default]` or `[[step]]`")]
pub(crate) struct UnknownSection {
    pub at: Span,
}

impl Finding for UnknownSection {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "unknown table")
            .help("write inputs under `[default]`, or under one `[[step]]` for each step")
    }
}
