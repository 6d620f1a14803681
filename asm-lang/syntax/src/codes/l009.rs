use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Operator of another language
///
/// AsmetaL writes `=` and `!=` for equality and inequality, and the words `and`, `or`, `not` and
/// `implies`.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = if n == 1 then skip endif
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
///   main rule r_Main = if n = 1 then skip endif
/// default init s0:
///   function n = 1
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L009, error)]
#[error("unexpected `{found}`")]
pub(crate) struct ForeignSign {
    pub found: String,
    pub meant: &'static str,
    pub text: String,
    pub at: Span,
}

impl Finding for ForeignSign {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { meant, .. } = self;
        let foreign = diagnostic.label(self.at, "spelling of another language");
        let foreign = match self.found.as_str() {
            "=>" => foreign.help("to compare, write `>=`"),
            _ => foreign,
        };
        foreign.fix(format!("write `{meant}`"), self.at, self.text.clone())
    }
}
