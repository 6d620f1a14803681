use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// An element of a run in a specification
///
/// `robot!1` is what a run calls the first element that `extend` made. A specification cannot know it:
/// it takes an element with `choose` or `forall`, or declares one. Scenarios and the prompt may name it.
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
/// Mended:
///
/// ```asm mended
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
#[error("`{word}` names an element of a run, which a specification cannot do")]
pub(crate) struct ElementName {
    pub word: String,
    pub at: Span,
}

impl Finding for ElementName {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "not part of a specification")
            .help("take an element by `choose` or `forall`, or declare it `static`")
    }
}
