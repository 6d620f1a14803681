use crate::foreign::Foreign;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Input outside its domain
///
/// A script, recording, scenario or binding must give a monitored or shared function an element of its
/// codomain, or undef. This includes the parts of tuples, sequences, sets, bags and maps.
///
/// ```asm
/// asm example
/// import StandardLibrary
/// signature:
///   domain Level subsetof Integer
///   monitored level: Level
///   controlled n: Integer
/// definitions:
///   domain Level = {0 : 9}
///   main rule r_Main = n := level
/// ```
///
/// ```avalla wrong
/// scenario s
/// load example.asm
/// set level := 12;
/// step
/// ```
///
/// Corrected:
///
/// ```avalla corrected
/// scenario s
/// load example.asm
/// set level := 3;
/// step
/// ```
///
/// AsmetaS checks only updates against their domain; `--compat asmeta` does the same.
#[derive(Debug, thiserror::Error, Coded)]
#[code(R022, error)]
#[error("{foreign} {when}")]
pub(crate) struct ReadsForeignValue {
    pub location: String,
    /// Codomain of the function, as text.
    pub codomain: String,
    pub foreign: Foreign,
    /// Source of the value, as in "the script".
    pub given_by: String,
    pub when: String,
    pub at: Span,
}

impl Finding for ReadsForeignValue {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let place = format!("`{}` takes values of `{}`", self.location, self.codomain);
        self.foreign
            .explain(
                diagnostic.label(self.at, place),
                "provide an element from the environment",
            )
            .note(format!("the value came from {}", self.given_by))
    }
}
