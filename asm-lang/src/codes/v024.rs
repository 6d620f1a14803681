use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Specification not found
///
/// The path after `load` is relative to the folder of the scenario.
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
/// load exmaple.asm
///
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
#[code(V024, error)]
#[error("specification `{path}` not found")]
pub(crate) struct UnknownSpecification {
    pub path: Arc<str>,
    pub at: Span,
}

impl Finding for UnknownSpecification {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "loaded here")
            .help("write the path relative to the folder of the scenario")
    }
}
