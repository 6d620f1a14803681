use asmotion_diagnostics::{Coded, Diagnostic, Finding};

/// Mission cannot start
///
/// The mission file or its composite cannot be read, the profile does not exist, or the composite cannot be assembled in this
/// build.
#[derive(Debug, thiserror::Error, Coded)]
#[code(V036, error)]
#[error("{reason}")]
pub struct MissionNotStarted {
    pub reason: String,
}

impl Finding for MissionNotStarted {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
    }
}
