use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Invalid script
///
/// A script is a TOML file with a `[default]` table and `[[step]]` tables that contain `name = value`
/// lines.
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
/// [default
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
#[code(S001, error)]
#[error("{message}")]
pub(crate) struct InvalidScript {
    /// The message of the TOML parser.
    pub message: String,
    pub at: Span,
}

impl Finding for InvalidScript {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "invalid TOML")
            .help("write a `[default]` table and `[[step]]` tables")
    }
}
