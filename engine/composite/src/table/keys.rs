//! Reads tables key by key and collects diagnostics.
//!
//! The keys requested define the permitted keys: dropping [`Keys`] reports all others as unknown.

use std::any::Any;
use std::collections::BTreeSet;
use std::sync::Arc;

use asmotion_datum::Word;
use asmotion_diagnostics::{Report, Span};

use super::{Key, Many, Outline, Value};
use crate::at::At;
use crate::codes::c003::UnknownKey;
use crate::codes::c004::MissingKey;
use crate::codes::c005::WrongKeyType;
use crate::codes::c006::UnknownOption;
use crate::codes::c007::KeyOutOfRange;
use crate::codes::c009::UnknownVariable;
use crate::codes::c010::ExclusiveKeys;
use crate::codes::c011::SubstitutionNotAllowed;
use crate::codes::c012::InvalidSubstitution;
use crate::finding::Findings;
use crate::nearest::{Nearest, nearest_name};
use crate::range::shown;
use crate::template::{self, Template};
use crate::tree::{Branch, Entries, Entry, Node, Table};

/// Source text being read and the diagnostics found in it.
pub(crate) struct Reader<'t> {
    text: &'t str,
    pub report: Report,
    /// Elements that are instances of one, each with the variables of its `for`, without `$`.
    pub instances: Vec<(Span, Vec<String>)>,
    /// Entries of tables of names that could not be read: the key of the table, and the name.
    pub unread: Vec<(&'static str, String)>,
    shared: Vec<SharedValue>,
}

/// A value read from a table that several instances share.
struct SharedValue {
    entries: Entries,
    value: Arc<dyn Any + Send + Sync>,
}

impl<'t> Reader<'t> {
    pub(crate) fn new(text: &'t str) -> Self {
        let report = Report::new();
        Self {
            text,
            report,
            instances: Vec::new(),
            unread: Vec::new(),
            shared: Vec::new(),
        }
    }

    /// Reads a value. Of a table that several instances share, the value that has been read for the first of them is returned, unless
    /// there were findings, which are about each of them.
    pub(crate) fn shared<V: Value + Send + Sync + 'static>(
        &mut self,
        key: &At<String>,
        spec: &Key,
        node: &Node,
    ) -> Option<Arc<V>> {
        let entries = if let Branch::Table(table) = &node.value
            && table.entries.is_shared()
        {
            &table.entries
        } else {
            return V::read(self, key, spec, node).map(Arc::new);
        };
        // instances of one element follow each other
        let mut shared = self.shared.iter().rev();
        let known = shared.find_map(|it| {
            let value = it
                .entries
                .is_shared_with(entries)
                .then(|| Arc::clone(&it.value));
            value?.downcast().ok()
        });
        if known.is_some() {
            return known;
        }
        let before = (self.report.diagnostics.len(), self.unread.len());
        let value = Arc::new(V::read(self, key, spec, node)?);
        if before == (self.report.diagnostics.len(), self.unread.len()) {
            self.shared.push(SharedValue {
                entries: entries.clone(),
                value: Arc::<V>::clone(&value),
            });
        }
        Some(value)
    }

    /// Returns the variable in a text that is none of the `for` of its element.
    pub(crate) fn unknown_variable(&self, text: &str, at: Span) -> Option<UnknownVariable> {
        let contains =
            |place: &Span| place.file == at.file && place.start <= at.start && at.end <= place.end;
        let mut instances = self.instances.iter().filter(|(place, _)| contains(place));
        let known = instances.next().map(|(_, known)| known.clone());
        UnknownVariable::in_text(text, known.unwrap_or_default())
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
            span,
            of,
            within: "",
            known: Vec::new(),
            is_known: vec![false; table.entries.len()],
            groups: table
                .entries
                .iter()
                .fold(0, |all, it| all | group(&it.key.value)),
        }
    }

    /// Opens a value that must be a table; reports other types.
    pub(crate) fn keys_of<'r, 'n>(
        &'r mut self,
        node: &'n Node,
        key: &str,
        of: &'static str,
        example: &str,
    ) -> Option<Keys<'r, 't, 'n>> {
        if let Branch::Table(table) = &node.value {
            Some(self.keys(table, of, node.span))
        } else {
            self.wrong_type(key, "a table", node, example);
            None
        }
    }

    /// Reads a string without substitutions.
    pub(crate) fn text(&mut self, key: &str, node: &Node, example: &str) -> Option<At<String>> {
        let Branch::Text(text) = &node.value else {
            self.wrong_type(key, "a string", node, example);
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

    /// Reads a string with substitutions.
    pub(crate) fn template(&mut self, key: &str, node: &Node, example: &str) -> Option<Template> {
        let Branch::Text(text) = &node.value else {
            self.wrong_type(key, "a string", node, example);
            return None;
        };
        match template::parse(text, node.span, self.exact(text, node.span)) {
            Ok(template) => Some(template),
            Err((reason, at)) => {
                self.report.found(InvalidSubstitution { reason, at });
                None
            }
        }
    }

    /// Reads a number and checks it against the range of its key.
    pub(crate) fn within(
        &mut self,
        key: &str,
        spec: &Key,
        number: f64,
        node: &Node,
    ) -> Option<f64> {
        if (spec.least..=spec.greatest).contains(&number) {
            return Some(number);
        }
        self.report.found(KeyOutOfRange {
            key: key.to_owned(),
            value: shown(number),
            least: shown(spec.least),
            greatest: shown(spec.greatest),
            at: node.span,
        });
        None
    }

    /// Reads one of a fixed set of words.
    pub(crate) fn word<T: Word>(&mut self, key: &str, spec: &Key, node: &Node) -> Option<T> {
        let known = T::words();
        let first = known.first().map(|word| format!("\"{word}\""));
        let example = match spec.example {
            "" => first.unwrap_or_default(),
            example => example.to_owned(),
        };
        let word = self.text(key, node, &example)?;
        let found = T::of_word(&word);
        if found.is_none() {
            let nearest = nearest_name(&word, known.iter().copied());
            self.unknown_word(key, &word, known, nearest);
        }
        found
    }

    pub(crate) fn unknown_word(
        &mut self,
        key: &str,
        word: &At<String>,
        known: Vec<&'static str>,
        nearest: Option<Nearest>,
    ) {
        self.report.found(UnknownOption {
            key: key.to_owned(),
            word: word.value.clone(),
            at: word.span,
            known,
            nearest,
        });
    }

    /// Returns whether the string contains no escapes, so that parts of it can be located in the file.
    pub(crate) fn exact(&self, text: &str, span: Span) -> bool {
        self.text.get(span.range()) == Some(text)
    }

    /// Returns the location of a part of a string; the whole string if escapes prevent this.
    pub(crate) fn part(&self, text: &At<String>, range: std::ops::Range<usize>) -> Span {
        if !self.exact(text, text.span) {
            return text.span;
        }
        let start = text.span.start as usize;
        Span::new(text.span.file, start + range.start, start + range.end)
    }

    /// Reports a value of an integer key, with the unit of the key.
    pub(crate) fn no_integer(&mut self, key: &str, spec: &Key, found: &Node, example: i64) {
        self.report.found(WrongKeyType {
            key: key.to_owned(),
            expected: "an integer",
            found: found.value.describe(),
            at: found.span,
            unit: spec.unit,
            example: example.to_string(),
        });
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
            unit: "",
            example: example.to_owned(),
        });
    }
}

/// A table being read.
pub(crate) struct Keys<'r, 't, 'n> {
    pub reader: &'r mut Reader<'t>,
    table: &'n Table,
    /// Location for reports of missing keys.
    pub span: Span,
    of: &'static str,
    /// Key of which the table is the value.
    pub within: &'static str,
    /// Keys requested so far, some repeatedly.
    known: Vec<&'static str>,
    /// For each entry of the table, whether its key has been requested.
    is_known: Vec<bool>,
    /// The groups of the keys of the table. Most keys that are requested are absent, and in no group of one that is present.
    groups: u64,
}

/// The group of a key, as one bit.
fn group(key: &str) -> u64 {
    let first = key.as_bytes().first().copied().unwrap_or_default();
    1 << ((usize::from(first) + key.len()) % 64)
}

impl<'n> Keys<'_, '_, 'n> {
    fn find(&mut self, key: &'static str) -> Option<&'n Entry> {
        self.known.push(key);
        if self.groups & group(key) == 0 {
            return None;
        }
        let (entry, is_known) = self.entry(key)?;
        *is_known = true;
        Some(entry)
    }

    fn entry(&mut self, key: &str) -> Option<(&'n Entry, &mut bool)> {
        let mut entries = self.table.entries.iter().zip(&mut self.is_known);
        entries.find(|(entry, _)| entry.key.value == key)
    }

    /// Marks the keys of an outline as known even if they are not read.
    pub(crate) fn know(&mut self, outline: &Outline) {
        for (key, _) in &outline.keys {
            self.find(key.name);
        }
    }

    /// Returns the location of a key; `None` if it is absent.
    pub(crate) fn place(&mut self, key: &'static str) -> Option<Span> {
        self.find(key).map(|entry| entry.key.span)
    }

    /// Reads an optional value; reports a missing key if it is required.
    pub(crate) fn optional<V: Value>(&mut self, key: &'static Key) -> Option<V> {
        if key.needed {
            self.need(key.name, key.example);
        }
        let Entry { key: name, node } = self.find(key.name)?;
        V::read(self.reader, name, key, node)
    }

    /// Reads a key with several values.
    pub(crate) fn many<V: Value>(&mut self, key: &'static Key) -> Vec<V> {
        if key.needed {
            self.need(key.name, key.example);
        }
        let Some(Entry { key: name, node }) = self.find(key.name) else {
            return Vec::new();
        };
        let reader = &mut *self.reader;
        let expected = match (V::MANY, &node.value) {
            (Many::OneOrList | Many::List(_) | Many::Tables, Branch::List(items)) => {
                let items = items.iter();
                let read = items.filter_map(|item| V::read(reader, name, key, item));
                return read.collect();
            }
            (Many::Names, Branch::Table(table)) => {
                let entries = table.entries.iter();
                let read = entries.filter_map(|it| {
                    let read = V::read(reader, &it.key, key, &it.node);
                    if read.is_none() {
                        reader.unread.push((key.name, it.key.value.clone()));
                    }
                    read
                });
                return read.collect();
            }
            (Many::OneOrList, _) => {
                return V::read(reader, name, key, node).into_iter().collect();
            }
            (Many::List(expected), _) => expected,
            (Many::Tables, _) => "a list of tables",
            (Many::Names, _) => "a table of names",
        };
        reader.wrong_type(name, expected, node, key.example);
        Vec::new()
    }

    /// Returns the index of the key that is present; reports that several are.
    pub(crate) fn one_of(&mut self, keys: &[&'static Key], reason: &'static str) -> Option<usize> {
        let mut found = Vec::new();
        for (index, key) in keys.iter().enumerate() {
            found.extend(self.place(key.name).map(|at| (index, key.name, at)));
        }
        let mut found = found.into_iter();
        let Some((index, first, first_at)) = found.next() else {
            if let Some(key) = keys.first() {
                self.need(key.name, key.example);
            }
            return None;
        };
        for (_, second, at) in found {
            self.excluded((first, first_at), (second, at), reason);
        }
        Some(index)
    }

    /// Reports two keys that exclude each other, if both are present.
    pub(crate) fn either(
        &mut self,
        first: &'static str,
        second: &'static str,
        reason: &'static str,
    ) {
        if let (Some(first_at), Some(at)) = (self.place(first), self.place(second)) {
            self.excluded((first, first_at), (second, at), reason);
        }
    }

    pub(crate) fn excluded(
        &mut self,
        (first, first_at): (&str, Span),
        (second, at): (&str, Span),
        reason: &'static str,
    ) {
        self.reader.report.found(ExclusiveKeys {
            first: first.to_owned(),
            first_at,
            second: second.to_owned(),
            at,
            reason,
        });
    }

    /// Reports a missing key.
    pub(crate) fn need(&mut self, key: &'static str, example: &str) {
        if self.find(key).is_none() {
            self.reader.report.found(MissingKey {
                key,
                of: self.of,
                at: self.span,
                example: example.to_owned(),
            });
        }
    }
}

impl Drop for Keys<'_, '_, '_> {
    fn drop(&mut self) {
        let entries = self.table.entries.iter().zip(&self.is_known);
        for (entry, _) in entries.filter(|(_, is_known)| !**is_known) {
            let key = entry.key.value.as_str();
            let known: BTreeSet<&'static str> = self.known.iter().copied().collect();
            self.reader.report.found(UnknownKey {
                key: key.to_owned(),
                of: self.of,
                at: entry.key.span,
                nearest: nearest_name(key, known.iter().copied()),
                known: known.into_iter().collect(),
                instead: None,
            });
        }
    }
}
