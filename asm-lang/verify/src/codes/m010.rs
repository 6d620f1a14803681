use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span, did_you_mean, similar};

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
    /// The function with the most similar name, which is the same name if the numbers of parameters differ.
    pub similar: Option<String>,
    pub at: Span,
}

impl NothingProvided {
    /// Looks for a function of the system with a similar name.
    pub fn of(function: String, at: Span, provided: &[String]) -> Self {
        let similar = similar(&function, provided).cloned();
        Self {
            function,
            similar,
            at,
        }
    }
}

impl Finding for NothingProvided {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let own = "a value that the environment decides itself is chosen: `choose $x in D with true do …`";
        match &self.similar {
            Some(function) if *function == self.function => diagnostic
                .label(
                    self.at,
                    "the function of this name in the system has other parameters",
                )
                .help("declare it with the parameters of the function")
                .help(own),
            Some(function) => diagnostic
                .label(self.at, "the system has no function of this name")
                .help(did_you_mean(function))
                .help(own),
            None => diagnostic
                .label(
                    self.at,
                    "the system has no controlled, out or shared function of this name",
                )
                .help(own),
        }
    }
}
