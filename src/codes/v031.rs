use asmotion_diagnostics::{Coded, Diagnostic, Finding};

/// A run that differs from its snapshot
///
/// The run reads, writes or prints something else than when it was accepted; the difference is shown. If
/// it is meant, accept it with `asmotion test --accept`, or one by one with `--review`.
#[derive(Debug, thiserror::Error, Coded)]
#[code(V031, error)]
#[error("the run differs from `{path}`")]
pub struct SnapshotDiffers {
    pub path: String,
}

impl Finding for SnapshotDiffers {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic.help("accept what is meant with `--accept`, or one by one with `--review`")
    }
}
