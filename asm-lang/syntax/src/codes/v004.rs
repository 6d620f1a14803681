use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Incomplete command
///
/// A part of the command is missing. The message shows its form.
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
/// execblock;
/// step
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
#[code(V004, error)]
#[error("expected {expected} after `{command}`")]
pub(crate) struct IncompleteCommand {
    pub command: &'static str,
    pub expected: &'static str,
    pub form: &'static str,
    pub at: Span,
}

impl Finding for IncompleteCommand {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            form,
            expected: wanted,
            ..
        } = self;
        diagnostic
            .label(self.at, format!("expected {wanted}"))
            .help(format!("write `{form}`"))
    }
}
