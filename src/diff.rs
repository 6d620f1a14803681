//! Two texts of one file as a unified diff.

use similar::TextDiff;

/// Unchanged lines shown around a change.
const CONTEXT: usize = 3;

/// What turns `before` into `after`, as `patch` reads it.
pub fn unified(path: &str, before: &str, after: &str) -> String {
    TextDiff::from_lines(before, after)
        .unified_diff()
        .context_radius(CONTEXT)
        .header(path, path)
        .to_string()
}
