use asmotion_diagnostics::{Coded, Diagnostic, Finding};

/// Missing snapshot
///
/// No result has been accepted for this run yet. Review its output, and accept it with `asmotion test
/// --accept`. If `CI` is set, nothing is accepted: commit the snapshot together with its script.
#[derive(Debug, thiserror::Error, Coded)]
#[code(V030, error)]
#[error("snapshot `{path}` not found")]
pub struct NoSnapshot {
    pub path: String,
}

impl Finding for NoSnapshot {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic.help("check the output of the run, then accept it with `--accept`")
    }
}
