use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Update of a monitored function
///
/// Monitored functions belong to the environment, which gives them a value in every step. Rules can
/// only read them.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   monitored speed: Integer
/// definitions:
///   main rule r_Main = speed := 1
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   shared speed: Integer
/// definitions:
///   main rule r_Main = speed := 1
/// ```
///
/// A `shared` function is written by both sides. An `out` function is written by rules and read by the
/// environment.
#[derive(Debug, thiserror::Error, Coded)]
#[code(A014, error)]
#[error("`{function}` is monitored, so no rule may update it")]
pub(crate) struct WritesMonitored {
    pub function: Arc<str>,
    pub at: Span,
    pub declared: Span,
}

impl Finding for WritesMonitored {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
                .label(self.at, "updated here")
                .label(self.declared, "declared monitored here")
                .help("declare it `shared` if rules also write it, or pass the value to the environment in an `out` function")
    }
}
