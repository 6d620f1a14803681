//! Fixes a file: rounds of safe fixes in memory, then one write.

use super::findings::findings;
use crate::build::Build;
use crate::files::{self, DiskLoader};
use asmotion_diagnostics::{LoadError, apply};
use asmotion_lang::{Loader, ReadOptions, Report, Sources};
use serde_json::{Value, json};
use std::fmt;
use std::sync::Arc;

/// Upper bound on the rounds of fixes for one file.
const MAX_ROUNDS: usize = 100;

/// A file before and after its fixes.
pub struct FixedFile {
    before: Arc<str>,
    after: Arc<str>,
    /// The applied fixes, in order.
    pub applied_fixes: Vec<AppliedFix>,
    /// The remaining findings.
    pub report: Report,
    /// The new text and the files it imports.
    pub sources: Sources,
}

/// A fix that was applied.
pub struct AppliedFix {
    code: &'static str,
    message: String,
    /// Line and column of the finding in the text of its round, from 1.
    line: usize,
    column: usize,
}

/// Applies safe fixes until none is left. Changes only this file, no imported one.
pub fn fix_file(build: &Build, path: &str, options: &ReadOptions) -> Result<FixedFile, LoadError> {
    let before = DiskLoader.read(path)?;
    let mut after = before.clone();
    let mut applied_fixes = Vec::new();
    let mut rounds = 0;
    loop {
        let (report, sources) = findings(build, path, options, &Overlay { path, text: &after });
        let file = sources.find(path).unwrap_or_default();
        let fixed = apply(&after, file, &report.diagnostics);
        if fixed.applied.is_empty() || *fixed.text == *after || rounds == MAX_ROUNDS {
            return Ok(FixedFile {
                before,
                after,
                applied_fixes,
                report,
                sources,
            });
        }
        applied_fixes.extend(fixed.applied.iter().map(|finding| {
            let at = finding.primary.as_ref().map(|label| label.span);
            let (line, column) = at.map_or((1, 1), |at| sources.position(at.file, at.start));
            AppliedFix {
                code: finding.code.name,
                message: finding.message.clone(),
                line,
                column,
            }
        }));
        after = fixed.text.into();
        rounds += 1;
    }
}

impl FixedFile {
    /// The changes as a diff.
    pub fn diff(&self, path: &str) -> String {
        crate::diff::unified(path, &self.before, &self.after)
    }

    /// Replaces the file by the new text.
    pub fn write(&self, path: &str) -> std::io::Result<()> {
        files::rewrite(path, &self.before, &self.after)
    }
}

impl AppliedFix {
    /// The applied fixes as JSON.
    pub fn json(&self, path: &str) -> Value {
        json!({
            "path": path, "line": self.line, "column": self.column,
            "code": self.code, "message": self.message,
        })
    }
}

impl fmt::Display for AppliedFix {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            code,
            message,
            line,
            column,
        } = self;
        write!(to, "{line}:{column}: [{code}] {message}")
    }
}

/// The disk with a replacement text at one path.
struct Overlay<'a> {
    path: &'a str,
    text: &'a Arc<str>,
}

impl Loader for Overlay<'_> {
    fn read(&self, path: &str) -> Result<Arc<str>, LoadError> {
        if path == self.path {
            Ok(self.text.clone())
        } else {
            DiskLoader.read(path)
        }
    }

    fn resolve(&self, from: &str, import: &str) -> Option<String> {
        DiskLoader.resolve(from, import)
    }
}
