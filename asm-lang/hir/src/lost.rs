//! Names that may come from an import that could not be loaded. They are not reported one by one.

use asmotion_diagnostics::{Diagnostic, Span};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::sync::Arc;

/// Number of names that a note lists.
const LISTED: usize = 5;

/// An import that could not be loaded, with the unknown names that it may declare.
#[derive(Debug)]
pub(crate) struct FailedImport {
    /// The path after `import` in backticks, or words in its place.
    pub shown: Arc<str>,
    /// The place that the finding about the import labels.
    pub at: Span,
    /// The unknown names of all units that may come from the import.
    pub names: BTreeSet<Arc<str>>,
}

/// A failed import whose names would be visible in a unit, directly or through imported units.
#[derive(Clone, Debug)]
pub(crate) struct LostImport {
    /// Index into the failed imports.
    pub failed: usize,
    /// The names that the clauses in between let through; `None` for all.
    pub names: Option<BTreeSet<Arc<str>>>,
}

impl LostImport {
    /// Returns the part of the lost names that another clause lets through, if any remain.
    pub fn through(&self, clause: Option<BTreeSet<Arc<str>>>) -> Option<Self> {
        let names = match (&self.names, clause) {
            (None, clause) => clause,
            (Some(names), None) => Some(names.clone()),
            (Some(names), Some(clause)) => Some(names & &clause),
        };
        let is_empty = names.as_ref().is_some_and(BTreeSet::is_empty);
        (!is_empty).then_some(Self {
            failed: self.failed,
            names,
        })
    }

    /// Returns `true` if a name may come from the import. A literal comes with its domain, which
    /// has another name.
    pub fn may_declare(&self, name: &str, literal: bool) -> bool {
        self.names.as_ref().is_none_or(|names| {
            let is_domain = |name: &Arc<str>| name.starts_with(char::is_uppercase);
            names.contains(name) || (literal && names.iter().any(is_domain))
        })
    }
}

impl FailedImport {
    /// Adds a note about the names to the finding about the import.
    pub fn note(&self, findings: &mut [Diagnostic]) {
        let is_about = |finding: &&mut Diagnostic| {
            let at = finding.primary.as_ref().map(|label| label.span);
            at == Some(self.at)
        };
        if let (Some(note), Some(finding)) = (self.text(), findings.iter_mut().find(is_about)) {
            finding.notes.push(note);
        }
    }

    fn text(&self) -> Option<String> {
        let first = self.names.first()?;
        let shown = &self.shown;
        if self.names.len() == 1 {
            return Some(format!(
                "`{first}` may come from {shown} and is not reported"
            ));
        }
        let mut listed = String::new();
        for name in self.names.iter().take(LISTED) {
            let separator = if listed.is_empty() { "" } else { ", " };
            // writing to a string cannot fail
            let _ = write!(listed, "{separator}`{name}`");
        }
        let more = if self.names.len() > LISTED {
            ", …"
        } else {
            ""
        };
        let count = self.names.len();
        Some(format!(
            "{count} names may come from {shown} and are not reported: {listed}{more}"
        ))
    }
}
