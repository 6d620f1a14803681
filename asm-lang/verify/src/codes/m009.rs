use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span, similar};

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
    pub similar: Option<String>,
    pub at: Span,
}

impl UnusedProvision {
    /// Looks for an input with a similar name.
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
        let diagnostic = diagnostic.label(
            self.at,
            "there is no input of this name and number of parameters",
        );
        match &self.similar {
            Some(input) => diagnostic.help(format!("the system reads `{input}`")),
            None => diagnostic.help("declare it `controlled` if only the environment needs it"),
        }
    }
}
