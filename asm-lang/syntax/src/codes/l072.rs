use crate::edits::all_sure;
use asmotion_diagnostics::{Coded, Diagnostic, Edit, Finding, Span};

/// Block with fewer than two rules
///
/// AsmetaS rejects `par` and `seq` with one rule or none. asmotion accepts them, and `asmotion check
/// --fix` removes the block.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = par n := 1 endpar
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
#[code(L072, warning)]
#[error("`{block}` with {count}")]
pub(crate) struct FewRules {
    pub block: &'static str,
    pub count: &'static str,
    pub at: Span,
    /// Edits that remove the block; empty if that could change the meaning.
    pub without: Vec<Edit>,
}

impl Finding for FewRules {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let few = diagnostic.label(self.at, "AsmetaS requires at least two rules");
        let help = match self.count {
            "no rule" => "write `skip` for a rule that does nothing",
            _ => "remove the block around a single rule",
        };
        match self.without.as_slice() {
            [] => few.help(help),
            edits => few.with_fix(all_sure(help, edits)),
        }
    }
}
