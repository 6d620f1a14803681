use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Assignment operator of another language
///
/// The rule `location := term` is the only update. `n++` and `n += 1` are written `n := n + 1`.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n += 1
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
///   main rule r_Main = n := n + 1
/// default init s0:
///   function n = 1
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L077, error)]
#[error("unexpected `{found}`")]
pub(crate) struct CompoundAssignment {
    /// The operator: `++`, `+=`.
    pub found: &'static str,
    /// The update in AsmetaL, if the location is simple; it replaces the operator.
    pub update: Option<(String, String)>,
    pub at: Span,
}

impl Finding for CompoundAssignment {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let diagnostic = diagnostic.label(self.at, "operator of another language");
        match &self.update {
            Some((whole, text)) => {
                diagnostic.fix(format!("write `{whole}`"), self.at, text.clone())
            }
            None => diagnostic.help("write an update, as in `n := n + 1`"),
        }
    }
}
