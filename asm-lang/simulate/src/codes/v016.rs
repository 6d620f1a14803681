use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// `undef` as a pick
///
/// `choose` selects an element of its range, and undef is not an element.
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
/// pick $x in r_Main := undef;
/// step
/// ```
///
/// Corrected:
///
/// ```avalla corrected
/// scenario example
/// load example.asm
///
/// set wish := 2;
/// pick $x in r_Main := 1;
/// step
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(V016, error)]
#[error("`undef` cannot be picked")]
pub(crate) struct PicksUndef {
    pub at: Span,
}

impl Finding for PicksUndef {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "not a candidate")
            .help("pick an element of the range, or remove the `pick`")
    }
}
