//! Where texts come from.

use std::sync::Arc;

/// Where texts come from. The language wing has no other door to files.
pub trait Loader {
    /// The text at `path`, which is as [`Loader::resolve`] returned it.
    ///
    /// # Errors
    /// The text cannot be had: missing, unreadable, too large or not UTF-8.
    fn read(&self, path: &str) -> Result<Arc<str>, LoadError>;

    /// The canonical path of `import`, as written in the file `from`: the same text always has the
    /// same path. `None` where no such text exists.
    fn resolve(&self, from: &str, import: &str) -> Option<String>;
}

/// Why a text cannot be had.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cannot read `{path}`: {reason}")]
pub struct LoadError {
    /// The path asked for.
    pub path: String,
    /// What the operating system, or the loader, said.
    pub reason: String,
}
