use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Duplicate block name
///
/// `execblock` calls a block by its name, so only the first of these blocks can be called.
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
/// end
/// begin first
///   step
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
/// begin second
///   step
/// end
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(V008, warning)]
#[error("duplicate block `{name}`")]
pub(crate) struct DuplicateBlock {
    pub name: String,
    pub at: Span,
    pub first: Span,
}

impl Finding for DuplicateBlock {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "cannot be run by name")
            .label(self.first, "first declared here")
            .help("rename one of them")
    }
}
