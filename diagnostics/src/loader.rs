//! The interface to source files.

use std::sync::Arc;

/// Reads source texts by path. The language crates access files through it only.
pub trait Loader {
    /// Reads the text at `path`, a path that [`Loader::resolve`] returned.
    ///
    /// # Errors
    /// The text is missing, unreadable, too large or not UTF-8.
    fn read(&self, path: &str) -> Result<Arc<str>, LoadError>;

    /// Returns the canonical path of `import`, as written in the file `from`, so that one text
    /// always has one path. Returns `None` if there is no such text.
    fn resolve(&self, from: &str, import: &str) -> Option<String>;
}

/// The failure to read a source text.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cannot read `{path}`: {reason}")]
pub struct LoadError {
    /// The path as passed to [`Loader::read`].
    pub path: String,
    /// Message of the operating system or of the loader.
    pub reason: String,
}
