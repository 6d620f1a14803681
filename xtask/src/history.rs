//! The files that a commit touched in order to add a single thing.
//!
//! A commit that adds exactly one key of the composite dialect, one property of a component or one
//! component carries a trailer: `Adds: key`, `Adds: property` or `Adds: component`. The figure is
//! computed from the latest such commit and is therefore the cost of an actual change, not an
//! estimate.

use crate::checkout::{CheckoutError, run};
use std::fmt;
use std::path::Path;

/// A kind of addition with a recipe in `ARCHITECTURE.md`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Addition {
    /// A key of the composite dialect.
    Key,
    /// A property of a component.
    Property,
    /// A component.
    Component,
}

/// Commits that add a single thing and predate the trailers, newest first.
const WITHOUT_TRAILER: &[(Addition, &str)] = &[
    // `heartbeat_s` of a broker
    (Addition::Key, "f9302e951528d3887672604d84025c973b4b41bc"),
    // `unavailable` of a call
    (Addition::Key, "c12f19de80791da1e2d1ef02ca5772dff0c8c58f"),
];

impl Addition {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Key, Self::Property, Self::Component];

    /// Returns the word used in the trailer.
    pub fn name(self) -> &'static str {
        match self {
            Self::Key => "key",
            Self::Property => "property",
            Self::Component => "component",
        }
    }
}

/// The files of a commit, without tests, documentation and the lock file.
#[derive(Clone, Debug)]
pub struct MarkedCommit {
    /// Abbreviated hash.
    pub hash: String,
    /// Existing files that the commit changed.
    pub changed: Vec<String>,
    /// Files that the commit added.
    pub added: Vec<String>,
}

impl fmt::Display for MarkedCommit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.changed.len())?;
        if !self.added.is_empty() {
            write!(f, " + {} new", self.added.len())?;
        }
        write!(f, " ({})", self.hash)
    }
}

/// Returns the latest commit up to a revision that adds a single thing of this kind; `None` if
/// there is none.
///
/// # Errors
/// `git` fails, for example because the revision is unknown.
pub fn latest(
    root: &Path,
    revision: &str,
    addition: Addition,
) -> Result<Option<MarkedCommit>, CheckoutError> {
    let pattern = format!("^Adds: {}$", addition.name());
    let found = run(
        "git",
        &["log", "-1", "--format=%H", "--grep", &pattern, revision],
        root,
    )?;
    let mut hash = found.trim().to_owned();
    if hash.is_empty() {
        let older = WITHOUT_TRAILER.iter().find(|(kind, hash)| {
            *kind == addition
                && run(
                    "git",
                    &["merge-base", "--is-ancestor", hash, revision],
                    root,
                )
                .is_ok()
        });
        match older {
            Some((_, older)) => (*older).clone_into(&mut hash),
            None => return Ok(None),
        }
    }
    let files = run(
        "git",
        &["show", "--format=", "--name-status", "--no-renames", &hash],
        root,
    )?;
    let mut commit = MarkedCommit {
        hash: hash.chars().take(7).collect(),
        changed: Vec::new(),
        added: Vec::new(),
    };
    for line in files.lines() {
        let Some((status, path)) = line.split_once('\t') else {
            continue;
        };
        if path.split('/').any(|folder| folder == "tests")
            || path.ends_with(".md")
            || path.ends_with(".lock")
        {
            continue;
        }
        match status {
            "A" => commit.added.push(path.to_owned()),
            _ => commit.changed.push(path.to_owned()),
        }
    }
    Ok(Some(commit))
}
