use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// An assignment is wanted
///
/// Where a location is set from outside, as in a scenario or in `asmotion repl`, it is written like an
/// update: a location, `:=`, and its value. `set speed(rob1) 3` lacks the sign; `set speed(rob1) := 3`
/// has it.
#[derive(Debug, thiserror::Error, Coded)]
#[code(L063, error)]
#[error("an assignment is wanted here")]
pub(crate) struct NotAnAssignment {
    pub at: Span,
}

impl Finding for NotAnAssignment {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "not of the form `location := term`")
            .help("write a location, `:=` and its value, as in `speed(rob1) := 3`")
    }
}
