use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Parentheses around rules
///
/// Parentheses enclose terms. Group rules with `par … endpar` or `seq … endseq`.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = (n := 1)
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
#[code(L036, error)]
#[error("brackets around a rule")]
pub(crate) struct BracketedRule {
    pub at: Span,
}

impl Finding for BracketedRule {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "expected a rule")
            .help("remove the brackets, or write `par … endpar`")
    }
}
