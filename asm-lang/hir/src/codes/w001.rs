use asmotion_diagnostics::{Applicability, Coded, Diagnostic, Finding, Fix, Span};

/// `not` before a comparison
///
/// `not` binds more tightly than a comparison: `not a = b` means `(not a) = b`.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled a: Boolean
///   controlled b: Boolean
/// definitions:
///   main rule r_Main = if not a = b then a := b endif
/// default init s0:
///   function a = true
///   function b = true
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled a: Boolean
///   controlled b: Boolean
/// definitions:
///   main rule r_Main = if not (a = b) then a := b endif
/// default init s0:
///   function a = true
///   function b = true
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(W001, warning)]
#[error("`not` binds tighter than `{operator}`: this reads `(not …) {operator} …`")]
pub(crate) struct NotBinds {
    pub operator: &'static str,
    pub at: Span,
    pub operand: Span,
    /// The comparison without the `not`.
    pub comparison: Span,
}

impl Finding for NotBinds {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { operator, .. } = self;
        diagnostic
            .label(self.at, format!("applies only to the left of `{operator}`"))
            .label(self.operand, "not to the whole comparison")
            .with_fix(Fix {
                applicability: Applicability::Maybe,
                ..negated(self.comparison)
            })
    }
}

/// Returns the fix that puts a comparison after `not` in brackets.
pub(crate) fn negated(comparison: Span) -> Fix {
    let Span { start, end, .. } = comparison;
    let at = |start, end| Span {
        start,
        end,
        ..comparison
    };
    Fix::sure("negate the comparison", at(start, start), "(").and(at(end, end), ")")
}
