use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Not an assignment
///
/// A scenario or `asmotion repl` sets a location with `:=`, as in an update. `set speed(rob1) 3` lacks
/// it; write `set speed(rob1) := 3`.
#[derive(Debug, thiserror::Error, Coded)]
#[code(L063, error)]
#[error("expected an assignment")]
pub(crate) struct NotAnAssignment {
    pub at: Span,
}

impl Finding for NotAnAssignment {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "not of the form `location := term`")
            .help("write `location := value`, as in `speed(rob1) := 3`")
    }
}
