use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unbound variable
///
/// The rule or term that binds the variable is not being executed, so the variable has no value.
/// `asmotion check` reports the place as W021.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = par choose $x in {1 : 3} do n := $x if $x = 1 then skip endif endpar
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
///   main rule r_Main = choose $x in {1 : 3} do par n := $x if $x = 1 then skip endif endpar
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(R017, error)]
#[error("unbound variable {when}")]
pub(crate) struct UnboundVariable {
    pub when: String,
    pub at: Span,
}

impl Finding for UnboundVariable {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "read outside the rule or term that binds it")
            .help("bind it here with `let`, `forall` or `choose`")
    }
}
