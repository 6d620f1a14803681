use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Empty file
///
/// A file starts with `asm` and a name, followed by `signature:` and `definitions:`.
///
/// ```asm wrong
/// // nothing yet
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
/// definitions:
///   main rule r_Main = skip
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L020, warning)]
#[error("empty file")]
pub(crate) struct EmptyFile {
    pub at: Span,
}

impl Finding for EmptyFile {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "expected `asm` and a name")
            .help("write at least `asm name signature: definitions:`")
    }
}
