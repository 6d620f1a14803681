//! Reads a table key by key, and says everything that is wrong with it.
//!
//! The keys that are asked for are the keys that exist: whatever is left over when [`Keys`] goes
//! is an unknown key.

use std::ops::RangeInclusive;

use source::{Report, Span};

use super::error::ReadError;
use super::template;
use crate::At;
use crate::choice::Choice;
use crate::finding::Findings;
use crate::model::{Amount, Template};
use crate::nearest::nearest_name;
use crate::tree::{Branch, Node, Table};

/// The text being read and what was found in it.
pub(crate) struct Reader<'t> {
    pub text: &'t str,
    pub report: Report,
}

impl<'t> Reader<'t> {
    pub(crate) fn new(text: &'t str) -> Self {
        Self {
            text,
            report: Report::new(),
        }
    }

    /// Opens a table.
    pub(crate) fn keys<'r, 'n>(
        &'r mut self,
        table: &'n Table,
        of: &'static str,
        span: Span,
    ) -> Keys<'r, 't, 'n> {
        Keys {
            reader: self,
            table,
            of,
            span,
            asked: Vec::new(),
        }
    }

    /// Opens a value that must be a table.
    pub(crate) fn keys_of<'r, 'n>(
        &'r mut self,
        node: &'n Node,
        key: &str,
        of: &'static str,
        example: &str,
    ) -> Option<Keys<'r, 't, 'n>> {
        match &node.value {
            Branch::Table(table) => Some(self.keys(table, of, node.span)),
            _ => {
                self.wrong_type(key, "a table", node, example);
                None
            }
        }
    }

    /// A text without substitution.
    pub(crate) fn text(&mut self, key: &str, node: &Node, example: &str) -> Option<At<String>> {
        let Branch::Text(text) = &node.value else {
            self.wrong_type(key, "a text", node, example);
            return None;
        };
        if text.contains("${") {
            self.report.found(ReadError::NoSubstitution {
                key: key.to_owned(),
                at: node.span,
            });
            return None;
        }
        Some(At::new(text.clone(), node.span))
    }

    /// A text with substitutions.
    pub(crate) fn template(
        &mut self,
        key: &str,
        node: &Node,
        example: &str,
    ) -> Option<At<Template>> {
        let Branch::Text(text) = &node.value else {
            self.wrong_type(key, "a text", node, example);
            return None;
        };
        match template::parse(text, node.span, self.exact(text, node.span)) {
            Ok(template) => Some(At::new(template, node.span)),
            Err((reason, at)) => {
                self.report.found(ReadError::BadSubstitution { reason, at });
                None
            }
        }
    }

    /// A whole number within a range.
    pub(crate) fn whole(
        &mut self,
        key: &str,
        node: &Node,
        range: RangeInclusive<i64>,
    ) -> Option<At<i64>> {
        let Branch::Integer(number) = node.value else {
            let meant = match &node.value {
                Branch::Text(text) => text.parse().ok().filter(|number| range.contains(number)),
                _ => None,
            };
            let example = meant.unwrap_or(*range.start().max(&1));
            self.wrong_type(key, "a whole number", node, &example.to_string());
            return None;
        };
        if !range.contains(&number) {
            self.report.found(ReadError::OutOfRange {
                key: key.to_owned(),
                value: number.to_string(),
                least: range.start().to_string(),
                greatest: range.end().to_string(),
                at: node.span,
            });
            return None;
        }
        Some(At::new(number, node.span))
    }

    /// Whether every character of the text stands in the file as it is, without escapes, so that
    /// a part of it can be pointed at.
    pub(crate) fn exact(&self, text: &str, span: Span) -> bool {
        self.text.get(span.range()) == Some(text)
    }

    /// The place of a part of a text; all of it where escapes hide the part.
    pub(crate) fn part(&self, text: &At<String>, range: std::ops::Range<usize>) -> Span {
        if !self.exact(text, text.span) {
            return text.span;
        }
        let start = text.span.start as usize;
        Span::new(text.span.file, start + range.start, start + range.end)
    }

    pub(crate) fn wrong_type(
        &mut self,
        key: &str,
        expected: &'static str,
        found: &Node,
        example: &str,
    ) {
        self.report.found(ReadError::WrongType {
            key: key.to_owned(),
            expected,
            found: found.value.describe(),
            at: found.span,
            example: example.to_owned(),
        });
    }

    /// A word out of a list.
    pub(crate) fn word<T: Choice>(&mut self, key: &str, node: &Node) -> Option<At<T>> {
        let example = T::WORDS
            .first()
            .map_or(String::new(), |(word, _)| format!("\"{word}\""));
        let word = self.text(key, node, &example)?;
        match T::WORDS.iter().find(|(known, _)| *known == word.value) {
            Some((_, choice)) => Some(At::new(*choice, word.span)),
            None => {
                let known: Vec<&'static str> = T::WORDS.iter().map(|(word, _)| *word).collect();
                self.report.found(ReadError::UnknownWord {
                    key: key.to_owned(),
                    nearest: nearest_name(&word, known.iter().copied()),
                    word: word.value,
                    at: word.span,
                    known,
                });
                None
            }
        }
    }
}

/// A table being read.
pub(crate) struct Keys<'r, 't, 'n> {
    pub reader: &'r mut Reader<'t>,
    table: &'n Table,
    /// What the table describes, as in "a wire".
    of: &'static str,
    pub span: Span,
    asked: Vec<&'static str>,
}

impl<'n> Keys<'_, '_, 'n> {
    /// The value of a key.
    pub(crate) fn node(&mut self, key: &'static str) -> Option<&'n Node> {
        self.entry(key).map(|(_, node)| node)
    }

    /// The place of a key and its value.
    pub(crate) fn entry(&mut self, key: &'static str) -> Option<(Span, &'n Node)> {
        self.asked.push(key);
        self.table
            .get(key)
            .map(|entry| (entry.key.span, &entry.node))
    }

    /// Says that the key is missing, if it is.
    pub(crate) fn need(&mut self, key: &'static str, example: &str) {
        if !self.asked.contains(&key) {
            self.asked.push(key);
        }
        if self.table.get(key).is_none() {
            let (of, at) = (self.of, self.span);
            let example = example.to_owned();
            self.reader.report.found(ReadError::MissingKey {
                key,
                of,
                at,
                example,
            });
        }
    }

    pub(crate) fn text(&mut self, key: &'static str, example: &str) -> Option<At<String>> {
        let node = self.node(key)?;
        self.reader.text(key, node, example)
    }

    pub(crate) fn needed_text(&mut self, key: &'static str, example: &str) -> Option<At<String>> {
        self.need(key, example);
        self.text(key, example)
    }

    /// One text or a list of them.
    pub(crate) fn texts(&mut self, key: &'static str, example: &str) -> Vec<At<String>> {
        let Some(node) = self.node(key) else {
            return Vec::new();
        };
        match &node.value {
            Branch::List(items) => items
                .iter()
                .filter_map(|item| self.reader.text(key, item, example))
                .collect(),
            _ => self.reader.text(key, node, example).into_iter().collect(),
        }
    }

    pub(crate) fn template(&mut self, key: &'static str, example: &str) -> Option<At<Template>> {
        let node = self.node(key)?;
        self.reader.template(key, node, example)
    }

    pub(crate) fn flag(&mut self, key: &'static str) -> Option<At<bool>> {
        let node = self.node(key)?;
        match node.value {
            Branch::Boolean(truth) => Some(At::new(truth, node.span)),
            _ => {
                self.reader.wrong_type(key, "a Boolean", node, "true");
                None
            }
        }
    }

    pub(crate) fn whole(
        &mut self,
        key: &'static str,
        range: RangeInclusive<i64>,
    ) -> Option<At<i64>> {
        let node = self.node(key)?;
        self.reader.whole(key, node, range)
    }

    /// A list of whole numbers.
    pub(crate) fn wholes(
        &mut self,
        key: &'static str,
        range: RangeInclusive<i64>,
        example: &str,
    ) -> Vec<At<i64>> {
        self.items(key, "a list of whole numbers", example, |reader, item| {
            reader.whole(key, item, range.clone())
        })
    }

    pub(crate) fn real(
        &mut self,
        key: &'static str,
        range: RangeInclusive<f64>,
    ) -> Option<At<f64>> {
        let node = self.node(key)?;
        let number = match node.value {
            Branch::Integer(number) => number as f64,
            Branch::Float(number) => number,
            _ => {
                self.reader
                    .wrong_type(key, "a number", node, &range.start().to_string());
                return None;
            }
        };
        if !range.contains(&number) {
            self.reader.report.found(ReadError::OutOfRange {
                key: key.to_owned(),
                value: number.to_string(),
                least: range.start().to_string(),
                greatest: range.end().to_string(),
                at: node.span,
            });
            return None;
        }
        Some(At::new(number, node.span))
    }

    /// A whole number, or a substitution that stands for one.
    pub(crate) fn amount(
        &mut self,
        key: &'static str,
        range: RangeInclusive<i64>,
    ) -> Option<At<Amount>> {
        let node = self.node(key)?;
        match &node.value {
            Branch::Text(text) if text.contains("${") => {
                let template = self.reader.template(key, node, "50")?;
                Some(template.map(Amount::Template))
            }
            _ => Some(self.reader.whole(key, node, range)?.map(Amount::Number)),
        }
    }

    pub(crate) fn word<T: Choice>(&mut self, key: &'static str) -> Option<At<T>> {
        let node = self.node(key)?;
        self.reader.word(key, node)
    }

    /// Every entry of a table of names.
    pub(crate) fn named<T>(
        &mut self,
        key: &'static str,
        example: &str,
        mut each: impl FnMut(&mut Reader<'_>, &At<String>, &Node) -> Option<T>,
    ) -> Vec<T> {
        let Some(node) = self.node(key) else {
            return Vec::new();
        };
        let Branch::Table(table) = &node.value else {
            self.reader
                .wrong_type(key, "a table of names", node, example);
            return Vec::new();
        };
        let entries = table.entries.iter();
        entries
            .filter_map(|entry| each(self.reader, &entry.key, &entry.node))
            .collect()
    }

    /// Every item of a list.
    pub(crate) fn items<T>(
        &mut self,
        key: &'static str,
        expected: &'static str,
        example: &str,
        mut each: impl FnMut(&mut Reader<'_>, &Node) -> Option<T>,
    ) -> Vec<T> {
        let Some(node) = self.node(key) else {
            return Vec::new();
        };
        let Branch::List(items) = &node.value else {
            self.reader.wrong_type(key, expected, node, example);
            return Vec::new();
        };
        items
            .iter()
            .filter_map(|item| each(self.reader, item))
            .collect()
    }

    /// A table under a key, read as a whole.
    pub(crate) fn table<T>(
        &mut self,
        key: &'static str,
        of: &'static str,
        example: &str,
        read: impl FnOnce(Keys<'_, '_, '_>) -> T,
    ) -> Option<T> {
        let node = self.node(key)?;
        self.reader.keys_of(node, key, of, example).map(read)
    }
}

impl Drop for Keys<'_, '_, '_> {
    fn drop(&mut self) {
        let mut known = std::mem::take(&mut self.asked);
        known.sort_unstable();
        known.dedup();
        for entry in &self.table.entries {
            let key = entry.key.value.as_str();
            if !known.contains(&key) {
                self.reader.report.found(ReadError::UnknownKey {
                    key: key.to_owned(),
                    of: self.of,
                    at: entry.key.span,
                    nearest: nearest_name(key, known.iter().copied()),
                    known: known.clone(),
                });
            }
        }
    }
}
