use crate::edits::SpannedText;
use asmotion_diagnostics::{Coded, Diagnostic, Finding};

/// Reserved word as a name
///
/// Keywords such as `do`, `in` and `out` cannot be used as names.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled do: Integer
/// definitions:
///   main rule r_Main = skip
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled todo: Integer
/// definitions:
///   main rule r_Main = skip
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L054, error)]
#[error("`{}` is a reserved word and cannot name {what}", found.0)]
pub(crate) struct ReservedName {
    pub found: SpannedText,
    pub what: &'static str,
}

impl Finding for ReservedName {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.found.1, "reserved word")
            .help("choose another name")
    }
}
