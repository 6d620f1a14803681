use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// A rule that updates a monitored function
///
/// Monitored functions belong to the environment: it gives them a value in every step, and rules only
/// read them.
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
/// Mended:
///
/// ```asm mended
/// asm example
/// import StandardLibrary
/// signature:
///   shared speed: Integer
/// definitions:
///   main rule r_Main = speed := 1
/// ```
///
/// `shared` lets both write; `out` is written by rules and read by the environment.
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
                .help("declare it `shared` if rules write it, too; what the environment is to hear goes to an `out` function")
    }
}
