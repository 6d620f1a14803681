use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unterminated block
///
/// A block that starts with `begin name` ends with `end`.
///
/// ```asm
/// asm example
/// import StandardLibrary
/// signature:
///   monitored wish: Integer
///   controlled n: Integer
/// definitions:
///   main rule r_Main = choose $x in {1 : 3} with $x != wish do n := $x
/// ```
///
/// ```avalla wrong
/// scenario example
/// load example.asm
///
/// begin first
///   step
/// ```
///
/// Corrected:
///
/// ```avalla corrected
/// scenario example
/// load example.asm
///
/// begin first
///   step
/// end
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(V006, error)]
#[error("unterminated block `{name}`")]
pub(crate) struct OpenBlock {
    pub name: String,
    pub at: Span,
}

impl Finding for OpenBlock {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "starts here and is never closed")
            .help("add `end` after its last command")
    }
}
