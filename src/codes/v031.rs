use asmotion_diagnostics::{Coded, Diagnostic, Finding};

/// Run differs from its snapshot
///
/// The inputs, updates or output of the run differ from the accepted snapshot; the message shows the
/// difference. If the change is intended, accept it with `asmotion test --accept`, or review each one
/// with `--review`.
#[derive(Debug, thiserror::Error, Coded)]
#[code(V031, error)]
#[error("the run differs from `{path}`")]
pub struct SnapshotDiffers {
    pub path: String,
}

impl Finding for SnapshotDiffers {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic.help("accept intended changes with `--accept`, or one by one with `--review`")
    }
}
