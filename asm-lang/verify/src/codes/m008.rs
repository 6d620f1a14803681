use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Input whose values differ from those that another machine provides
///
/// An input of one machine that reads a function of another one, or of the environment, must have a domain with the same elements.
/// Literals of enumerations correspond by name. Integers correspond to integers: whether one is in the domain of the input is checked
/// in each step.
///
/// ```text wrong
/// // system                                    // environment
/// signature:                                   signature:
///   enum domain Answer = {NO | YES}              enum domain Answer = {NO | YES | MAYBE}
///   monitored answer: Answer                     out answer: Answer
/// ```
///
/// ```text corrected
/// // system                                    // environment
/// signature:                                   signature:
///   enum domain Answer = {NO | YES}              enum domain Answer = {NO | YES}
///   monitored answer: Answer                     out answer: Answer
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(M008, error)]
#[error("`{source_machine}` provides `{input}` with another domain than the input has")]
pub(crate) struct ConnectionMismatch {
    pub input: String,
    pub source_machine: String,
    /// Signature of the input.
    pub expected: String,
    /// Signature of the function that provides it.
    pub found: String,
    pub at: Span,
}

impl Finding for ConnectionMismatch {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let (expected, found) = (&self.expected, &self.found);
        diagnostic
            .label(self.at, format!("the input is {expected}"))
            .note(format!("`{}` provides {found}", self.source_machine))
            .help("declare both with the same domains; literals correspond by name")
    }
}
