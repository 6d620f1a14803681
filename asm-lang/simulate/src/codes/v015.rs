use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Unknown rule in a `pick`
///
/// `pick $x in r_rule := …` names the rule that contains the `choose`.
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
/// pick $x in r_Mian := 1;
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
/// pick $x in r_Main := 1;
/// step
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(V015, error)]
#[error("unknown rule `{name}`")]
pub(crate) struct UnknownChooseRule {
    pub name: String,
    pub at: Span,
    pub similar: Option<Arc<str>>,
}

impl Finding for UnknownChooseRule {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "not declared in the specification")
            .did_you_mean(self.at, self.similar.as_deref())
            .help("name the rule that contains the `choose`")
    }
}
