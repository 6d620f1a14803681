use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Result stored in a monitored function
///
/// AsmetaS accepts this, but monitored functions belong to the environment, which will overwrite the
/// value.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   monitored wish: Integer
/// definitions:
///   turbo rule r_one in Integer = result := 1
///   main rule r_Main = wish <- r_one()
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled wish: Integer
/// definitions:
///   turbo rule r_one in Integer = result := 1
///   main rule r_Main = wish <- r_one()
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(W023, warning)]
#[error("`{function}` is monitored, so the environment overwrites this result")]
pub(crate) struct ReturnsToMonitored {
    pub function: Arc<str>,
    pub at: Span,
    pub declared: Span,
}

impl Finding for ReturnsToMonitored {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "written here")
            .label(self.declared, "declared monitored here")
            .help("declare it `controlled`, or `shared` if both may write it")
    }
}
