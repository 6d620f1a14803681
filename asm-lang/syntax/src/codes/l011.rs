use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Name of an element that `extend` creates
///
/// `robot!1` is the name of the first element that `extend` creates during a run, so a specification
/// cannot refer to it. Select an element with `choose` or `forall`, or declare one. Scenarios and the
/// prompt may use such names.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   abstract domain Robot
///   controlled at: Robot -> Integer
/// definitions:
///   main rule r_Main = at(robot!1) := 5
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   abstract domain Robot
///   static rob1: Robot
///   controlled at: Robot -> Integer
/// definitions:
///   main rule r_Main = at(rob1) := 5
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L011, error)]
#[error("`{word}` names an element that exists only during a run")]
pub(crate) struct ElementName {
    pub word: String,
    pub at: Span,
}

impl Finding for ElementName {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "cannot be named in a specification")
            .help("select an element with `choose` or `forall`, or declare it `static`")
    }
}
