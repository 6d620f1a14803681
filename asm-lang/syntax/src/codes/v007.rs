use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unmatched `end`
///
/// No block is open here.
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
/// step
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
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(V007, error)]
#[error("unmatched `end`")]
pub(crate) struct StrayBlockEnd {
    pub at: Span,
}

impl Finding for StrayBlockEnd {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "no block is open here")
            .help("remove it, or write `begin name` before the block")
    }
}
