//! The source texts that spans refer to.

use crate::span::{FileId, Span};
use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

/// A text and the path it was read from.
#[derive(Clone, Debug)]
struct SourceText {
    path: String,
    text: Arc<str>,
    /// Byte offsets at which lines begin, once a position in the text has been asked for.
    line_starts: OnceLock<Arc<[usize]>>,
}

impl SourceText {
    fn line_starts(&self) -> &[usize] {
        self.line_starts.get_or_init(|| {
            let breaks = self.text.match_indices('\n');
            std::iter::once(0)
                .chain(breaks.map(|(at, _)| at + 1))
                .collect()
        })
    }
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
            line_starts: OnceLock::new(),
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

    /// Converts a byte offset to line and column, both counted from 1; columns count characters. An unknown id has only the first
    /// position.
    ///
    /// The time grows with the logarithm of the number of lines: steps of a running specification ask for the places of their updates.
    pub fn position(&self, file: FileId, offset: u32) -> (usize, usize) {
        let Some(file) = self.files.get(file.0 as usize) else {
            return (1, 1);
        };
        let text = &*file.text;
        let mut offset = (offset as usize).min(text.len());
        while !text.is_char_boundary(offset) {
            offset -= 1;
        }
        let starts = file.line_starts();
        let line = starts.partition_point(|start| *start <= offset);
        let start = starts.get(line.saturating_sub(1)).copied().unwrap_or(0);
        let before = text.get(start..offset).unwrap_or("");
        (line, before.chars().count() + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares every offset of a text, and some beyond it, with lines and columns that are counted from its beginning.
    #[test]
    fn positions_are_those_that_are_counted_from_the_beginning() {
        let texts = [
            "",
            "\n",
            "one",
            "one\n",
            "one\n\ntwo\r\n",
            "ä\nö€\n\u{1F916}x",
        ];
        for text in texts {
            let mut sources = Sources::new();
            let file = sources.add("some.asm", text);
            for offset in 0..text.len() + 3 {
                let mut end = offset.min(text.len());
                while !text.is_char_boundary(end) {
                    end -= 1;
                }
                let (mut line, mut column) = (1, 1);
                for letter in text[..end].chars() {
                    (line, column) = match letter {
                        '\n' => (line + 1, 1),
                        _ => (line, column + 1),
                    };
                }
                let found = sources.clone().position(file, offset as u32);
                assert_eq!(found, (line, column), "{text:?} at {offset}");
            }
        }
    }

    #[test]
    fn an_unknown_text_has_one_position() {
        assert_eq!(Sources::new().position(FileId(3), 7), (1, 1));
    }
}
