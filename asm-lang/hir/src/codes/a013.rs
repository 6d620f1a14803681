use asmotion_diagnostics::{Coded, Diagnostic, Finding, LoadError, Span};

/// Unreadable file
///
/// The file is missing, not accessible, a folder, or too large. The message gives the reason.
#[derive(Debug, thiserror::Error, Coded)]
#[code(A013, error)]
#[error("{error}")]
pub(crate) struct UnreadableFile {
    pub error: LoadError,
    pub at: Option<Span>,
}

impl Finding for UnreadableFile {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { at, .. } = self;
        let finding = diagnostic;
        let finding = match at {
            Some(at) => finding.label(*at, "imported here"),
            None => finding,
        };
        finding.help("check the path")
    }
}
