use crate::seen::meant;
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
/// Mended:
///
/// ```avalla mended
/// scenario example
/// load example.asm
///
/// set wish := 2;
/// pick $x := 1;
/// step
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(V014, error)]
#[error("no `choose` binds `{variable}`")]
pub(crate) struct UnknownChoice {
    pub variable: String,
    pub rule: Option<String>,
    pub at: Span,
    pub similar: Option<Arc<str>>,
}

impl Finding for UnknownChoice {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { rule, similar, .. } = self;
        let place = match rule {
            Some(rule) => format!("no `choose` of `{rule}` does"),
            None => "no rule of the specification does".to_owned(),
        };
        meant(diagnostic.label(self.at, place), self.at, similar)
            .help("name a variable that stands behind `choose`")
    }
}
