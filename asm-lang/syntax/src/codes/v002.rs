use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Missing `load`
///
/// `load` names the specification of the scenario. Its path is relative to the scenario.
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
/// step
/// ```
///
/// Corrected:
///
/// ```avalla corrected
/// scenario example
/// load example.asm
///
/// step
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(V002, error)]
#[error("missing `load` command")]
pub(crate) struct NoLoadCommand {
    pub at: Span,
}

impl Finding for NoLoadCommand {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "expected `load`")
            .help("write `load specification.asm`, with a path relative to the scenario")
    }
}
