use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// `local` in a signature
///
/// A local function belongs to the body of a turbo rule. In a signature it is treated as controlled;
/// AsmetaS rejects it.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   local n: Integer
/// definitions:
///   main rule r_Main = n := 1
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
#[code(W026, warning)]
#[error("`{name}` is declared `local` outside a rule")]
pub(crate) struct LocalInSignature {
    pub name: Arc<str>,
    pub at: Span,
}

impl Finding for LocalInSignature {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
                .label(self.at, "treated as a controlled function")
                .help("declare it `controlled`, or move it before the body of a turbo rule, as in `local f: Integer [f := 0]`")
    }
}
