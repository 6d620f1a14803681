use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Scenario not found
///
/// `execblock other:block` reads `other.avalla` in the folder of this scenario.
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
/// execblock other:first;
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
#[code(V012, error)]
#[error("scenario `{name}` not found")]
pub(crate) struct UnknownScenario {
    pub name: String,
    pub at: Span,
}

impl Finding for UnknownScenario {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "no such file in this folder")
            .help("write the name of the file without `.avalla`")
    }
}
