use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Picked value is not a candidate
///
/// A scenario picked a value that is not in the range of the `choose`, or for which its guard does not
/// hold.
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
/// pick $x in r_Main := 7;
/// step
/// ```
///
/// Corrected:
///
/// ```avalla corrected
/// scenario example
/// load example.asm
///
/// set wish := 1;
/// pick $x in r_Main := 2;
/// step
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(R020, error)]
#[error("cannot pick {values} {when}")]
pub(crate) struct PickedNoCandidate {
    /// The picked values, separated by commas.
    pub values: String,
    pub when: String,
    pub at: Span,
}

impl Finding for PickedNoCandidate {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "not a candidate of this `choose`")
            .help("pick a value of the range that satisfies the guard")
    }
}
