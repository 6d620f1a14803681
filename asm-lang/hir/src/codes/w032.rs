use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Interpolation in a text
///
/// A text is taken literally: `${n}` in it is not replaced by the value of `n`. Texts are concatenated
/// with `+`; `toString` converts any other value.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
///   controlled message: String
/// definitions:
///   main rule r_Main = message := "n = ${n}"
/// default init s0:
///   function n = 3
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
///   controlled message: String
/// definitions:
///   main rule r_Main = message := "n = " + toString(n)
/// default init s0:
///   function n = 3
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(W032, warning)]
#[error("`{placeholder}` is part of the text, not the value of `{name}`")]
pub(crate) struct InterpolatedText {
    /// From `${` to `}`.
    pub placeholder: String,
    /// The function, or the variable with its `$`.
    pub name: Arc<str>,
    /// `true` if the values of the name are texts.
    pub is_text: bool,
    pub at: Span,
    pub declared: Span,
}

impl Finding for InterpolatedText {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { name, .. } = self;
        let value = if self.is_text {
            name.to_string()
        } else {
            format!("toString({name})")
        };
        diagnostic
            .label(self.at, "taken literally")
            .label(self.declared, "declared here")
            .help(format!("concatenate: `\"…\" + {value}`"))
    }
}
