use crate::edits::SpannedText;
use asmotion_diagnostics::{Coded, Diagnostic, Finding};

/// Missing rule
///
/// A rule is required here. `skip` is the rule that does nothing.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = if n = 1 then else n := 1 endif
/// default init s0:
///   function n = 1
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
///   main rule r_Main = if n = 1 then skip else n := 1 endif
/// default init s0:
///   function n = 1
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L035, error)]
#[error("missing rule before `{}`", found.0)]
pub(crate) struct MissingRule {
    pub found: SpannedText,
    pub after: Option<SpannedText>,
}

impl Finding for MissingRule {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { after, .. } = self;
        let missing = diagnostic.label(self.found.1, "expected a rule before this");
        let missing = match after {
            Some((word, span)) => missing.label(*span, format!("`{word}` needs a rule")),
            None => missing,
        };
        missing.help("write `skip` for a rule that does nothing")
    }
}
