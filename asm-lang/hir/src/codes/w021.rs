use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Variable read outside its binding
///
/// AsmetaS accepts a variable that is bound elsewhere in the rule. A run that reads it here fails with
/// R017, because it has no value.
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
#[code(W021, warning)]
#[error("`{name}` is read outside its binding")]
pub(crate) struct OutOfScope {
    pub name: Arc<str>,
    pub at: Span,
    pub bound: Span,
}

impl Finding for OutOfScope {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
                .label(self.at, "fails when it is evaluated")
                .label(self.bound, "bound here, only for the following rule or term")
                .help("move the use into that rule or term, or bind the variable again with `let`, `forall` or `choose`")
    }
}
