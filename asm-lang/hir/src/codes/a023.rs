use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Main rule with parameters
///
/// The main rule is not called by another rule, so it gets no arguments. Bind the values it needs
/// inside the rule.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main($x in Integer) = n := $x
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = choose $x in {1 : 9} do n := $x
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A023, error)]
#[error("the main rule cannot have parameters")]
pub(crate) struct MainParameters {
    pub at: Span,
}

impl Finding for MainParameters {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "declared with parameters")
            .help("bind the values with `let`, `choose` or `forall` inside the rule")
    }
}
