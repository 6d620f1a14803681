use asmotion_diagnostics::{Coded, Diagnostic, Finding, LoadError, Span};

/// A file that cannot be read
///
/// The file is missing, is a folder, may not be read, or is too large. The message gives the
/// reason.
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
