use asmotion_diagnostics::{Coded, Diagnostic, Finding};

/// A snapshot scenario without a snapshot
///
/// Nothing was accepted yet that the run could be held against. Read what it writes, and accept it with
/// `asmotion test --accept`. Where `CI` is set nothing is accepted: commit the snapshot with its script.
#[derive(Debug, thiserror::Error, Coded)]
#[code(V030, error)]
#[error("there is no snapshot `{path}`")]
pub struct NoSnapshot {
    pub path: String,
}

impl Finding for NoSnapshot {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic.help("read what the run wrote, and accept it with `--accept`")
    }
}
