use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span, did_you_mean, similar};

/// Environment with an out function that nothing reads
///
/// In `--environment FILE.asm`, the out functions of the environment are the inputs of the system with the same names and numbers
/// of parameters. One without such an input has no effect, and the input that was meant would have any value.
///
/// ```text wrong
/// // system                                    // environment
/// signature:                                   signature:
///   monitored estop: Boolean                     out eStop: Boolean
/// ```
///
/// ```text corrected
/// // system                                    // environment
/// signature:                                   signature:
///   monitored estop: Boolean                     out estop: Boolean
/// ```
///
/// A function that the environment needs for itself is `controlled`.
#[derive(Debug, thiserror::Error, Coded)]
#[code(M009, error)]
#[error("no machine reads `{function}` of the environment")]
pub(crate) struct UnusedProvision {
    pub function: String,
    /// The input with the most similar name, which is the same name if the numbers of parameters differ.
    pub similar: Option<String>,
    pub at: Span,
}

impl UnusedProvision {
    /// Looks for a similar name among the inputs that have no source.
    pub fn of(function: String, at: Span, inputs: &[String]) -> Self {
        let similar = similar(&function, inputs).cloned();
        Self {
            function,
            similar,
            at,
        }
    }
}

impl Finding for UnusedProvision {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let own = "declare it `controlled` if only the environment needs it";
        match &self.similar {
            Some(input) if *input == self.function => diagnostic
                .label(self.at, "the input of this name has other parameters")
                .help("declare it with the parameters of the input")
                .help(own),
            Some(input) => diagnostic
                .label(self.at, "no input of this name needs a value")
                .help(did_you_mean(input))
                .help(own),
            None => diagnostic
                .label(self.at, "no input of this name needs a value")
                .help(own),
        }
    }
}
