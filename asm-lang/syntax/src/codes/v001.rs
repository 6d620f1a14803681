use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Missing heading of a scenario
///
/// A scenario starts with `scenario` and its name.
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
/// load example.asm
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
#[code(V001, error)]
#[error("missing `scenario` at the start of the file")]
pub(crate) struct NoScenarioHeading {
    pub at: Span,
}

impl Finding for NoScenarioHeading {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "expected `scenario` before this")
            .help("start the file with `scenario name` and `load specification.asm`")
    }
}
