use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Unknown literal
///
/// A name that starts with a capital is a literal of an enumeration or a domain. No enumeration or
/// domain declares this one.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   enum domain Mode = {IDLE | BUSY}
///   controlled mode: Mode
/// definitions:
///   main rule r_Main = mode := IDEL
/// ```
///
/// Mended:
///
/// ```asm mended
/// asm example
/// import StandardLibrary
/// signature:
///   enum domain Mode = {IDLE | BUSY}
///   controlled mode: Mode
/// definitions:
///   main rule r_Main = mode := IDLE
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A005, error)]
#[error("`{name}` is neither an enumeration literal nor a domain")]
pub(crate) struct UnknownConstant {
    pub name: Arc<str>,
    pub at: Span,
    pub similar: Option<Arc<str>>,
}

impl Finding for UnknownConstant {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { similar, .. } = self;
        let finding = diagnostic.label(self.at, "unknown name");
        match similar {
            Some(name) => {
                finding.guess(format!("did you mean `{name}`?"), self.at, name.to_string())
            }
            None => finding.help(
                "names that begin with a capital are literals of an `enum domain`, or domains",
            ),
        }
    }
}
