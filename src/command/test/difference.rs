//! Differences between runs and their snapshots.

use crate::diff::unified;
use std::path::PathBuf;

/// A run that differs from its snapshot.
pub struct SnapshotDifference {
    /// Path of the snapshot.
    pub path: PathBuf,
    /// Accepted text, if there is a snapshot.
    pub accepted: Option<String>,
    /// Text of the run.
    pub actual: String,
}

impl SnapshotDifference {
    /// The changes from the accepted text to that of the run.
    pub fn diff(&self) -> String {
        let accepted = self.accepted.as_deref().unwrap_or("");
        unified(&self.path.to_string_lossy(), accepted, &self.actual)
    }

    /// Writes the text of the run as the new snapshot.
    pub fn accept(&self) -> std::io::Result<()> {
        std::fs::write(&self.path, &self.actual)
    }
}
