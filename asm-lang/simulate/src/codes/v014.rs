use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Unknown variable of a `pick`
///
/// `pick` determines the value of a `choose` variable. No `choose` binds this variable.
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
/// pick $y := 1;
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
/// pick $x := 1;
/// step
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(V014, error)]
#[error("unknown variable `{variable}` in a `pick`")]
pub(crate) struct UnknownChoice {
    pub variable: String,
    pub rule: Option<String>,
    pub at: Span,
    pub similar: Option<Arc<str>>,
}

impl Finding for UnknownChoice {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { rule, .. } = self;
        let place = match rule {
            Some(rule) => format!("not bound by a `choose` of `{rule}`"),
            None => "not bound by a `choose` of the specification".to_owned(),
        };
        diagnostic
            .label(self.at, place)
            .did_you_mean(self.at, self.similar.as_deref())
            .help("name a variable that a `choose` binds")
    }
}
