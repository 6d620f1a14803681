use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Environment that reads something that nothing provides
///
/// In `--environment FILE.asm`, the monitored functions of the environment read the controlled, out and shared functions of the
/// system with the same names and numbers of parameters. There is no further environment behind it: what it decides itself, it
/// chooses.
///
/// ```text wrong
/// // system                                    // environment
/// signature:                                   signature:
///   out moving: Boolean                          monitored isMoving: Boolean
/// ```
///
/// ```text corrected
/// // system                                    // environment
/// signature:                                   signature:
///   out moving: Boolean                          monitored moving: Boolean
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(M010, error)]
#[error("nothing provides `{function}`, which the environment reads")]
pub(crate) struct NothingProvided {
    pub function: String,
    pub at: Span,
}

impl Finding for NothingProvided {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "the system has no controlled, out or shared function of this name and number of parameters")
            .help("name a function of the system, or choose a value: `choose $x in D with true do …`")
    }
}
