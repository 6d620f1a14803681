use crate::edits::SpannedText;
use asmotion_diagnostics::{Coded, Diagnostic, Finding};

/// Wrong beginning of a name
///
/// The beginning of a name shows its kind: `$x` is a variable, `r_x` a rule, a lower-case name a
/// function, a capitalised name a domain, and a name with two capitals a literal of an enumeration.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   rule set = n := 1
///   main rule r_Main = skip
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
///   rule r_set = n := 1
///   main rule r_Main = r_set[]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L056, error)]
#[error("the name of {what} must start with {beginning}")]
pub(crate) struct Misnamed {
    pub what: &'static str,
    pub beginning: &'static str,
    pub found: SpannedText,
    pub better: Option<String>,
}

impl Finding for Misnamed {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { better, .. } = self;
        let misnamed = diagnostic.label(self.found.1, "invalid name");
        match better {
            Some(better) => misnamed.guess(
                format!("rename it to `{better}`"),
                self.found.1,
                better.clone(),
            ),
            None => misnamed,
        }
    }
}
