use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Quantifier without parentheses
///
/// The terms `forall` and `exists` are written in parentheses.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled ok: Boolean
/// definitions:
///   main rule r_Main = ok := forall $x in {1 : 3} with $x > 0
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled ok: Boolean
/// definitions:
///   main rule r_Main = ok := (forall $x in {1 : 3} with $x > 0)
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L038, error)]
#[error("missing parentheses around `{word}`")]
pub(crate) struct BareQuantifier {
    pub word: &'static str,
    pub at: Span,
}

impl Finding for BareQuantifier {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { word, .. } = self;
        diagnostic
            .label(self.at, "expected `(` before this")
            .help(format!("write `({word} $x in D with …)`"))
    }
}
