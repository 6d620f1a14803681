use crate::edits::SpannedText;
use asmotion_diagnostics::{Coded, Diagnostic, Finding};

/// Reserved word without a meaning
///
/// AsmetaL reserves `try`, `catch`, `endcase` and `FAIRNESS`, but does not use them.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = try n := 1 catch n := 2
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
///   main rule r_Main = n := 1
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L057, error)]
#[error("unexpected reserved word `{}`", found.0)]
pub(crate) struct UnusedWord {
    pub found: SpannedText,
}

impl Finding for UnusedWord {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { found } = self;
        unused(diagnostic, found)
    }
}

fn unused(diagnostic: Diagnostic, found: &SpannedText) -> Diagnostic {
    let diagnostic = diagnostic.label(found.1, "AsmetaL reserves this word and never uses it");
    match found.0.as_str() {
        "endcase" => {
            diagnostic.help("a case ends where the next one begins, the last at `endswitch`")
        }
        "FAIRNESS" | "fairness" => diagnostic.help("write `JUSTICE` or `COMPASSION`"),
        _ => diagnostic,
    }
}
