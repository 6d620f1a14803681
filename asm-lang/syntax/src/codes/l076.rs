use crate::edits::all_sure;
use asmotion_diagnostics::{Coded, Diagnostic, Edit, Finding, Span};

/// Rule called before its declaration
///
/// AsmetaS reads a file once from top to bottom and knows only the rules declared so far. asmotion
/// accepts any order; `asmotion check --fix` moves the rule. Turbo rules that call each other cannot be
/// ordered and are not reported.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   rule r_first = r_second[]
///   rule r_second = n := 1
///   main rule r_Main = r_first[]
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
///   rule r_second = n := 1
///   rule r_first = r_second[]
///   main rule r_Main = r_first[]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L076, warning)]
#[error("`{rule}` is called before its declaration")]
pub(crate) struct CalledEarly {
    pub rule: String,
    pub at: Span,
    pub declared: Span,
    /// Edits that move the rule before its first call.
    pub moved: Vec<Edit>,
}

impl Finding for CalledEarly {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { moved, .. } = self;
        diagnostic
            .label(self.at, "not yet declared for AsmetaS")
            .label(self.declared, "declared here")
            .with_fix(all_sure("move the declaration before the call", moved))
    }
}
