//! Reads a table key by key, and says everything that is wrong with it.
//!
//! The keys that are asked for are the keys that exist: whatever is left over when [`Keys`] goes
//! is an unknown key.

use crate::codes::c003::UnknownKey;
use crate::codes::c004::MissingKey;
use crate::codes::c005::WrongKeyType;
use crate::codes::c006::UnknownOption;
use crate::codes::c007::KeyOutOfRange;
use crate::codes::c010::ExclusiveKeys;
use crate::codes::c011::SubstitutionNotAllowed;
use crate::codes::c012::InvalidSubstitution;
use std::ops::RangeInclusive;

use asmotion_diagnostics::{Report, Span};

use super::outline::{Asked, Fields, Way};
use super::template;
use crate::At;
use crate::finding::Findings;
use crate::model::{Amount, Template};
use crate::nearest::nearest_name;
use crate::tree::{Branch, Node, Table};
use asmotion_datum::Word;

/// The text being read and what was found in it.
pub(crate) struct Reader<'t> {
    pub text: &'t str,
    pub report: Report,
    /// What was asked of the value being read.
    pub asked: Asked,
}

impl<'t> Reader<'t> {
    pub(crate) fn new(text: &'t str) -> Self {
        Self {
            text,
            report: Report::new(),
            asked: Asked::default(),
        }
    }

    /// Opens a table.
    pub(crate) fn keys<'r, 'n>(
        &'r mut self,
        table: &'n Table,
        of: &'static str,
        span: Span,
    ) -> Keys<'r, 't, 'n> {
        let outer = std::mem::take(&mut self.asked);
        Keys {
            reader: self,
            table,
            span,
            fields: Fields::new(of),
            open: None,
            outer,
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
        self.asked.add(Way::Text);
        self.plain(key, node, example)
    }

    /// The same where more was asked than that it is a text.
    pub(crate) fn plain(&mut self, key: &str, node: &Node, example: &str) -> Option<At<String>> {
        let Branch::Text(text) = &node.value else {
            self.wrong_type(key, "a text", node, example);
            return None;
        };
        if text.contains("${") {
            self.report.found(SubstitutionNotAllowed {
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
        self.asked.add(Way::Text);
        self.filled(key, node, example)
    }

    fn filled(&mut self, key: &str, node: &Node, example: &str) -> Option<At<Template>> {
        let Branch::Text(text) = &node.value else {
            self.wrong_type(key, "a text", node, example);
            return None;
        };
        match template::parse(text, node.span, self.exact(text, node.span)) {
            Ok(template) => Some(At::new(template, node.span)),
            Err((reason, at)) => {
                self.report.found(InvalidSubstitution { reason, at });
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
        self.asked.add(Way::Whole(*range.start(), *range.end()));
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
            self.report.found(KeyOutOfRange {
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
        self.report.found(WrongKeyType {
            key: key.to_owned(),
            expected,
            found: found.value.describe(),
            at: found.span,
            example: example.to_owned(),
        });
    }

    /// A word out of a list.
    pub(crate) fn word<T: Word>(&mut self, key: &str, node: &Node) -> Option<At<T>> {
        let known = T::words();
        self.asked.add(Way::word(known.iter().copied()));
        let example = known
            .first()
            .map_or(String::new(), |word| format!("\"{word}\""));
        let word = self.plain(key, node, &example)?;
        match T::of_word(&word.value) {
            Some(choice) => Some(At::new(choice, word.span)),
            None => {
                self.report.found(UnknownOption {
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

    /// Every entry of a table of names.
    pub(crate) fn names<T>(
        &mut self,
        table: &Table,
        mut each: impl FnMut(&mut Self, &At<String>, &Node) -> Option<T>,
    ) -> Vec<T> {
        let outer = std::mem::take(&mut self.asked);
        let entries = table.entries.iter();
        let read = entries.filter_map(|entry| each(self, &entry.key, &entry.node));
        let read = read.collect();
        let asked = std::mem::replace(&mut self.asked, outer);
        self.asked.add(Way::Names(asked));
        read
    }

    /// Every item of a list.
    pub(crate) fn list<T>(
        &mut self,
        items: &[Node],
        mut each: impl FnMut(&mut Self, &Node) -> Option<T>,
    ) -> Vec<T> {
        let outer = std::mem::take(&mut self.asked);
        let read = items.iter().filter_map(|item| each(self, item)).collect();
        let asked = std::mem::replace(&mut self.asked, outer);
        self.asked.add(Way::List(asked));
        read
    }
}

/// A table being read.
pub(crate) struct Keys<'r, 't, 'n> {
    pub reader: &'r mut Reader<'t>,
    table: &'n Table,
    pub span: Span,
    /// What was asked for so far.
    fields: Fields,
    /// The key whose value is being read.
    open: Option<&'static str>,
    /// What was asked of the value that this table is.
    outer: Asked,
}

impl<'n> Keys<'_, '_, 'n> {
    /// The value of a key.
    pub(crate) fn node(&mut self, key: &'static str) -> Option<&'n Node> {
        self.entry(key).map(|(_, node)| node)
    }

    /// The place of a key and its value.
    pub(crate) fn entry(&mut self, key: &'static str) -> Option<(Span, &'n Node)> {
        self.settle();
        self.open = Some(key);
        self.fields.keys.entry(key).or_default();
        self.table
            .get(key)
            .map(|entry| (entry.key.span, &entry.node))
    }

    /// Writes down what was asked of the value that was read last.
    fn settle(&mut self) {
        let asked = std::mem::take(&mut self.reader.asked);
        let open = self
            .open
            .take()
            .and_then(|key| self.fields.keys.get_mut(key));
        if let Some(field) = open {
            field.asked.merge(asked);
        }
    }

    /// The value of a key that is to be written in this way.
    pub(crate) fn ask(&mut self, key: &'static str, way: Way) -> Option<&'n Node> {
        let node = self.node(key);
        self.reader.asked.add(way);
        node
    }

    /// The value of the one key of these that is there, and what it is; that there are several is said, and
    /// that there is none.
    pub(crate) fn one_of(
        &mut self,
        keys: &'static [&'static str],
        example: &str,
        reason: &'static str,
    ) -> Option<(&'static str, At<String>)> {
        let mut found = Vec::new();
        for key in keys {
            self.ask(key, Way::Text);
            found.extend(self.entry(key).map(|(at, node)| (*key, at, node)));
        }
        let mut found = found.into_iter();
        let first = found.next();
        self.fields.choose(keys, first.map(|(key, _, _)| key));
        let Some((first, first_at, node)) = first else {
            let key = keys.first().copied().unwrap_or_default();
            self.missing(key, example);
            return None;
        };
        for (second, at, _) in found {
            self.reader.report.found(ExclusiveKeys {
                first: first.to_owned(),
                first_at,
                second: second.to_owned(),
                at,
                reason,
            });
        }
        Some((first, self.reader.plain(first, node, example)?))
    }

    /// Says that the key is missing, if it is.
    pub(crate) fn need(&mut self, key: &'static str, example: &str) {
        let field = self.fields.keys.entry(key).or_default();
        field.needed = true;
        field.example = Some(example.to_owned());
        self.missing(key, example);
    }

    fn missing(&mut self, key: &'static str, example: &str) {
        if self.table.get(key).is_none() {
            let (of, at) = (self.fields.of, self.span);
            let example = example.to_owned();
            self.reader.report.found(MissingKey {
                key,
                of,
                at,
                example,
            });
        }
    }

    pub(crate) fn text(&mut self, key: &'static str, example: &str) -> Option<At<String>> {
        let node = self.ask(key, Way::Text);
        self.example(key, example);
        self.reader.text(key, node?, example)
    }

    fn example(&mut self, key: &'static str, example: &str) {
        if let Some(field) = self.fields.keys.get_mut(key) {
            field.example = Some(example.to_owned());
        }
    }

    pub(crate) fn needed_text(&mut self, key: &'static str, example: &str) -> Option<At<String>> {
        self.need(key, example);
        self.text(key, example)
    }

    /// One text or a list of them.
    pub(crate) fn texts(&mut self, key: &'static str, example: &str) -> Vec<At<String>> {
        let node = self.ask(key, Way::Text);
        let texts = Asked {
            ways: vec![Way::Text],
        };
        self.reader.asked.add(Way::List(texts));
        self.example(key, example);
        let Some(node) = node else {
            return Vec::new();
        };
        match &node.value {
            Branch::List(items) => {
                (self.reader).list(items, |reader, item| reader.text(key, item, example))
            }
            _ => self.reader.text(key, node, example).into_iter().collect(),
        }
    }

    pub(crate) fn template(&mut self, key: &'static str, example: &str) -> Option<At<Template>> {
        let node = self.ask(key, Way::Text);
        self.example(key, example);
        self.reader.template(key, node?, example)
    }

    pub(crate) fn flag(&mut self, key: &'static str) -> Option<At<bool>> {
        let node = self.ask(key, Way::Flag)?;
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
        let node = self.ask(key, Way::Whole(*range.start(), *range.end()))?;
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
        let node = self.ask(key, Way::Real(*range.start(), *range.end()))?;
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
            self.reader.report.found(KeyOutOfRange {
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
        let node = self.ask(key, Way::Whole(*range.start(), *range.end()));
        self.reader.asked.add(Way::Substituted);
        let node = node?;
        match &node.value {
            Branch::Text(text) if text.contains("${") => {
                let template = self.reader.filled(key, node, "50")?;
                Some(template.map(Amount::Template))
            }
            _ => Some(self.reader.whole(key, node, range)?.map(Amount::Number)),
        }
    }

    pub(crate) fn word<T: Word>(&mut self, key: &'static str) -> Option<At<T>> {
        let node = self.ask(key, Way::word(T::words().into_iter()))?;
        self.reader.word(key, node)
    }

    /// One word or a list of them.
    pub(crate) fn words<T: Word>(&mut self, key: &'static str) -> Vec<At<T>> {
        let word = Way::word(T::words().into_iter());
        let node = self.ask(key, word.clone());
        self.reader.asked.add(Way::List(Asked { ways: vec![word] }));
        let Some(node) = node else {
            return Vec::new();
        };
        match &node.value {
            Branch::List(items) => (self.reader).list(items, |reader, item| reader.word(key, item)),
            _ => self.reader.word(key, node).into_iter().collect(),
        }
    }

    /// Every entry of a table of names.
    pub(crate) fn named<T>(
        &mut self,
        key: &'static str,
        example: &str,
        each: impl FnMut(&mut Reader<'_>, &At<String>, &Node) -> Option<T>,
    ) -> Vec<T> {
        let node = self.node(key);
        self.example(key, example);
        let Some(node) = node else {
            return Vec::new();
        };
        let Branch::Table(table) = &node.value else {
            self.reader
                .wrong_type(key, "a table of names", node, example);
            return Vec::new();
        };
        self.reader.names(table, each)
    }

    /// Every item of a list.
    pub(crate) fn items<T>(
        &mut self,
        key: &'static str,
        expected: &'static str,
        example: &str,
        each: impl FnMut(&mut Reader<'_>, &Node) -> Option<T>,
    ) -> Vec<T> {
        let node = self.node(key);
        self.example(key, example);
        let Some(node) = node else {
            return Vec::new();
        };
        let Branch::List(items) = &node.value else {
            self.reader.wrong_type(key, expected, node, example);
            return Vec::new();
        };
        self.reader.list(items, each)
    }

    /// A table under a key, read as a whole.
    pub(crate) fn table<T>(
        &mut self,
        key: &'static str,
        of: &'static str,
        example: &str,
        read: impl FnOnce(Keys<'_, '_, '_>) -> T,
    ) -> Option<T> {
        let node = self.node(key);
        self.example(key, example);
        self.reader.keys_of(node?, key, of, example).map(read)
    }
}

impl Drop for Keys<'_, '_, '_> {
    fn drop(&mut self) {
        self.settle();
        let known: Vec<&'static str> = self.fields.keys.keys().copied().collect();
        for entry in &self.table.entries {
            let key = entry.key.value.as_str();
            if !known.contains(&key) {
                self.reader.report.found(UnknownKey {
                    key: key.to_owned(),
                    of: self.fields.of,
                    at: entry.key.span,
                    nearest: nearest_name(key, known.iter().copied()),
                    known: known.clone(),
                });
            }
        }
        let mut fields = std::mem::take(&mut self.fields);
        fields.close();
        self.reader.asked = std::mem::take(&mut self.outer);
        self.reader.asked.add(Way::Table(fields));
    }
}
