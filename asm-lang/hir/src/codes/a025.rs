use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Wrong kind of call
///
/// A macro rule is called with square brackets and gets terms. A turbo rule is called with round
/// brackets and gets values.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   turbo rule r_set($x in Integer) = n := $x
///   main rule r_Main = r_set[1]
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
///   turbo rule r_set($x in Integer) = n := $x
///   main rule r_Main = r_set(1)
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A025, error)]
#[error("{is} rule `{name}` is called as a {}", other_form(is))]
pub(crate) struct WrongCallForm {
    pub name: Arc<str>,
    pub is: &'static str,
    pub want: &'static str,
    pub at: Span,
    pub declared: Span,
}

impl Finding for WrongCallForm {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "called here")
            .label(self.declared, "declared here")
            .help(self.want)
    }
}

/// Returns the kind of rule that the form of the call is meant for.
fn other_form(is: &str) -> &'static str {
    match is {
        "turbo" => "macro rule",
        _ => "turbo rule",
    }
}
