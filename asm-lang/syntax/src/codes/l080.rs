use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Element with its domain
///
/// An element of an enumeration is written without its domain: `RUN`, not `Mode.RUN`.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   enum domain Mode = {RUN | STOP}
///   controlled mode: Mode
///   controlled n: Integer
/// definitions:
///   main rule r_Main = if mode = Mode.RUN then mode := STOP endif
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
///   enum domain Mode = {RUN | STOP}
///   controlled mode: Mode
///   controlled n: Integer
/// definitions:
///   main rule r_Main = if mode = RUN then mode := STOP endif
/// default init s0:
///   function n = 1
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L080, error)]
#[error("`{written}`: an element is written without its domain")]
pub(crate) struct QualifiedElement {
    /// The domain and the element as written: `Mode.RUN`.
    pub written: String,
    /// The element: `RUN`.
    pub element: String,
    pub at: Span,
}

impl Finding for QualifiedElement {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let write = format!("write `{}`", self.element);
        diagnostic.label(self.at, "element with its domain").fix(
            write,
            self.at,
            self.element.clone(),
        )
    }
}
