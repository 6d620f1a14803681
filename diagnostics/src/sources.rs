//! The source texts that spans refer to.

use crate::span::{FileId, Span};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A text and the path it was read from.
#[derive(Clone, Debug)]
struct SourceText {
    path: String,
    text: Arc<str>,
}

/// All texts read by one run of a tool, indexed by [`FileId`].
#[derive(Clone, Debug, Default)]
pub struct Sources {
    files: Vec<SourceText>,
    by_path: BTreeMap<String, FileId>,
}

impl Sources {
    /// Creates an empty collection.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a text, or returns the id the path already has.
    pub fn add(&mut self, path: &str, text: impl Into<Arc<str>>) -> FileId {
        if let Some(&id) = self.by_path.get(path) {
            return id;
        }
        let id = FileId(u32::try_from(self.files.len()).unwrap_or(u32::MAX));
        self.files.push(SourceText {
            path: path.to_owned(),
            text: text.into(),
        });
        self.by_path.insert(path.to_owned(), id);
        id
    }

    /// Returns the id of a path, or `None` if it was not added.
    pub fn find(&self, path: &str) -> Option<FileId> {
        self.by_path.get(path).copied()
    }

    /// Returns the path of a text, empty for an unknown id.
    pub fn path(&self, file: FileId) -> &str {
        self.files
            .get(file.0 as usize)
            .map_or("", |file| &file.path)
    }

    /// Returns the paths of all files, in the order in which they were added.
    pub fn paths(&self) -> impl Iterator<Item = &str> {
        self.files.iter().map(|file| &*file.path)
    }

    /// Returns a text, empty for an unknown id.
    pub fn text(&self, file: FileId) -> &str {
        self.files
            .get(file.0 as usize)
            .map_or("", |file| &file.text)
    }

    /// Returns a shared handle to a text, empty for an unknown id.
    pub fn shared_text(&self, file: FileId) -> Arc<str> {
        self.files
            .get(file.0 as usize)
            .map_or_else(|| Arc::from(""), |file| file.text.clone())
    }

    /// Returns the characters covered by a span, empty if the span lies outside its text.
    pub fn snippet(&self, span: Span) -> &str {
        self.text(span.file).get(span.range()).unwrap_or("")
    }

    /// Converts a byte offset to line and column, both counted from 1; columns count characters.
    pub fn position(&self, file: FileId, offset: u32) -> (usize, usize) {
        let text = self.text(file);
        let mut offset = (offset as usize).min(text.len());
        while !text.is_char_boundary(offset) {
            offset -= 1;
        }
        let before = &text[..offset];
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
        (line, column)
    }
}
