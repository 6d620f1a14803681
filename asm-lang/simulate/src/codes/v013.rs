use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Block runs itself
///
/// A block may not run itself, directly or through other blocks: the scenario would never end.
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
///   execblock first;
/// end
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
/// execblock first;
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(V013, error)]
#[error("block `{name}` runs itself")]
pub(crate) struct CircularBlock {
    pub name: String,
    pub at: Span,
}

impl Finding for CircularBlock {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "runs it again, directly or through other blocks")
            .help("repeat the commands instead")
    }
}
