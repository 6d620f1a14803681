use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Missing `;`
///
/// `set`, `check`, `exec`, `pick` and `step until` end with `;`. `asmotion check --fix` and `asmotion
/// fmt` add it.
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
/// set wish := 1
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
/// step
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(V005, warning)]
#[error("missing `;` at the end of a command")]
pub(crate) struct UnendedCommand {
    pub command: Span,
    /// Span of the first word after the command.
    pub next: Span,
    /// Position for the `;`.
    pub end: Span,
}

impl Finding for UnendedCommand {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.next, "expected `;` before this")
            .label(self.command, "the command starts here")
            .fix("add `;`", self.end, ";")
    }
}
