use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Redundant definition
///
/// A constant that is defined as itself exists already as an element of its domain.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   abstract domain Robot
///   static rob1: Robot
/// definitions:
///   function rob1 = rob1
///   main rule r_Main = skip
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   abstract domain Robot
///   static rob1: Robot
/// definitions:
///   main rule r_Main = skip
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(W024, warning)]
#[error("redundant definition of `{name}`")]
pub(crate) struct DefinesItself {
    pub name: Arc<str>,
    pub at: Span,
}

impl Finding for DefinesItself {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "already an element of its domain")
            .help("remove the definition")
    }
}
