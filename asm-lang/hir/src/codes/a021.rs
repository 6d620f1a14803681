use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Wrong kind of definition
///
/// Static and derived functions are defined under `definitions:`; the others get an initial value in an
/// initial state. Only a domain that is a subset of another one is defined by its elements.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   function n = 1
///   main rule r_Main = skip
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
///   main rule r_Main = skip
/// default init s0:
///   function n = 1
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A021, error)]
#[error("`{name}` is {kind} and cannot be defined here")]
pub(crate) struct DefinesWrongKind {
    pub name: Arc<str>,
    pub kind: &'static str,
    pub why: &'static str,
    pub help: &'static str,
    pub at: Span,
    /// Span of the declaration; `None` for a library function.
    pub declared: Option<Span>,
}

impl Finding for DefinesWrongKind {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { declared, .. } = self;
        let finding = diagnostic.label(self.at, self.why).help(self.help);
        match declared {
            Some(declared) => finding.label(*declared, "declared here"),
            None => finding,
        }
    }
}
