use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Invariant after the first command
///
/// The invariants of a scenario are declared before its commands.
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
/// invariant small: isUndef(n) or n < 9;
/// ```
///
/// Corrected:
///
/// ```avalla corrected
/// scenario example
/// load example.asm
///
/// invariant small: isUndef(n) or n < 9;
/// step
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(V009, error)]
#[error("`{word}` after the first command")]
pub(crate) struct LateHeading {
    pub word: &'static str,
    pub at: Span,
}

impl Finding for LateHeading {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "too late in the scenario")
            .help("move it before the first command")
    }
}
