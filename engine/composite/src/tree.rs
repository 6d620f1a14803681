//! TOML syntax tree with the source location of every key and value.

use std::ops::{Deref, DerefMut};
use std::sync::Arc;

use asmotion_diagnostics::{FileId, Span};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::at::At;

/// A value with its source location.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Source location; for a `[table]` that of its header.
    pub span: Span,
    /// Content of the node.
    pub value: Branch,
}

/// A TOML value.
#[derive(Clone, Debug, PartialEq)]
pub enum Branch {
    /// String.
    Text(String),
    /// Integer.
    Integer(i64),
    /// Floating-point number.
    Float(f64),
    /// `true` or `false`.
    Boolean(bool),
    /// Date or time, as written.
    Date(String),
    /// Array.
    List(Vec<Node>),
    /// Table, inline or not.
    Table(Table),
}

/// Keys of a table in file order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Entries in file order; keys are unique.
    pub entries: Entries,
}

/// The entries of a table: a vector that its copies share until one of them changes. So the instances of an element, of which there can
/// be thousands, have one copy of each table in which no variable occurs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Entries(Arc<Vec<Entry>>);

impl Entries {
    /// Returns whether there are copies.
    pub(crate) fn is_shared(&self) -> bool {
        Arc::strong_count(&self.0) > 1
    }

    /// Returns whether both are the same vector. Entries that are equal but not shared are not.
    pub(crate) fn is_shared_with(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Deref for Entries {
    type Target = Vec<Entry>;

    fn deref(&self) -> &Vec<Entry> {
        &self.0
    }
}

impl DerefMut for Entries {
    fn deref_mut(&mut self) -> &mut Vec<Entry> {
        Arc::make_mut(&mut self.0)
    }
}

impl FromIterator<Entry> for Entries {
    fn from_iter<I: IntoIterator<Item = Entry>>(entries: I) -> Self {
        Self(Arc::new(entries.into_iter().collect()))
    }
}

impl IntoIterator for Entries {
    type Item = Entry;
    type IntoIter = std::vec::IntoIter<Entry>;

    fn into_iter(self) -> Self::IntoIter {
        Arc::unwrap_or_clone(self.0).into_iter()
    }
}

impl<'e> IntoIterator for &'e Entries {
    type Item = &'e Entry;
    type IntoIter = std::slice::Iter<'e, Entry>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<'e> IntoIterator for &'e mut Entries {
    type Item = &'e mut Entry;
    type IntoIter = std::slice::IterMut<'e, Entry>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter_mut()
    }
}

/// An entry of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Key and its source location.
    pub key: At<String>,
    /// Value of the key.
    pub node: Node,
}

impl Table {
    /// Creates a table with one key.
    pub(crate) fn short(key: &str, node: &Node) -> Self {
        let (key, node) = (At::new(key.to_owned(), node.span), node.clone());
        let entries = [Entry { key, node }];
        Self {
            entries: entries.into_iter().collect(),
        }
    }

    /// Returns the entry of a key.
    pub fn get(&self, key: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.key.value == key)
    }

    /// Merges another table over this one: tables of the same name are merged, other values are replaced.
    pub fn lay(&mut self, over: Self) {
        for entry in over.entries {
            let mut known = self.entries.iter_mut();
            match known.find(|known| known.key.value == entry.key.value) {
                Some(known) => known.lay(entry),
                None => self.entries.push(entry),
            }
        }
    }

    /// Sets a key to a table; a new key gets the location `span`.
    pub(crate) fn set(&mut self, key: &str, table: Self, span: Span) {
        let value = Branch::Table(table);
        match self.entries.iter_mut().find(|it| it.key.value == key) {
            Some(entry) => entry.node.value = value,
            None => self.entries.push(Entry {
                key: At::new(key.to_owned(), span),
                node: Node { span, value },
            }),
        }
    }
}

impl Entry {
    fn lay(&mut self, over: Self) {
        let Self { key, node } = over;
        match (&mut self.node.value, node.value) {
            (Branch::Table(under), Branch::Table(over)) => under.lay(over),
            (_, value) => {
                let span = node.span;
                let node = Node { span, value };
                *self = Self { key, node };
            }
        }
    }
}

impl Branch {
    /// Returns the value if it is a string.
    pub(crate) fn text(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text),
            Self::Integer(_)
            | Self::Float(_)
            | Self::Boolean(_)
            | Self::Date(_)
            | Self::List(_)
            | Self::Table(_) => None,
        }
    }

    /// Returns the type for use in messages, such as "a string" or "a list".
    pub fn describe(&self) -> &'static str {
        match self {
            Self::Text(_) => "a string",
            Self::Integer(_) => "an integer",
            Self::Float(_) => "a floating-point number",
            Self::Boolean(_) => "a Boolean",
            Self::Date(_) => "a date",
            Self::List(_) => "a list",
            Self::Table(_) => "a table",
        }
    }
}

/// A syntax error.
pub(crate) struct TomlError {
    pub message: String,
    pub span: Span,
    /// Location of the first occurrence of a duplicate key or header.
    pub earlier: Option<Span>,
}

/// Parses TOML with error recovery; returns the readable part of the tree and all errors.
pub(crate) fn parse(file: FileId, text: &str) -> (Table, Vec<TomlError>) {
    let (root, errors) = DeTable::parse_recoverable(text);
    let mut grower = Grower {
        file,
        text,
        errors: Vec::new(),
    };
    // end of the last duplicate table; its keys are reported as duplicates only because of the table
    let mut second_table = 0;
    for error in errors {
        let span = error.span().unwrap_or(0..0);
        let duplicate = error.message() == "duplicate key";
        if duplicate && span.start < second_table {
            continue;
        }
        let earlier = duplicate
            .then(|| earlier_header(text, span.start))
            .flatten();
        if earlier.is_some() {
            let rest = text.get(span.start..).unwrap_or("");
            second_table = span.start + rest.find("\n[").unwrap_or(rest.len());
        }
        let earlier = earlier.map(|range| Span::new(file, range.start, range.end));
        let span = Span::new(file, span.start, span.end);
        grower.errors.push(TomlError {
            message: error.message().to_owned(),
            span,
            earlier,
        });
    }
    let table = grower.table(root.get_ref());
    (table, grower.errors)
}

/// Returns the first occurrence of the `[header]` at `offset`. The parser reports only the location of the duplicate.
fn earlier_header(text: &str, offset: usize) -> Option<std::ops::Range<usize>> {
    let header = |line: &str| -> Option<String> {
        let line = line.trim();
        let inner = line.strip_prefix('[')?;
        inner
            .split_once(']')
            .map(|(name, _)| name.trim().to_owned())
    };
    let start = text
        .get(..offset)?
        .rfind('\n')
        .map_or(0, |newline| newline + 1);
    let wanted = header(text.get(start..)?.lines().next()?)?;
    let mut position = 0;
    for line in text.get(..start)?.split_inclusive('\n') {
        if header(line).as_deref() == Some(&wanted) {
            let indent = line.len() - line.trim_start().len();
            return Some(position + indent..position + line.trim_end().len());
        }
        position += line.len();
    }
    None
}

/// Converts the parser's tree, which borrows the text and is unordered, to a [`Table`] in file order.
struct Grower<'t> {
    file: FileId,
    text: &'t str,
    errors: Vec<TomlError>,
}

impl Grower<'_> {
    fn table(&mut self, table: &DeTable<'_>) -> Table {
        let mut entries: Vec<Entry> = table
            .iter()
            .map(|(key, value)| Entry {
                key: At::new(key.get_ref().to_string(), self.content(key.span())),
                node: self.node(value),
            })
            .collect();
        entries.sort_by_key(|entry| entry.key.span);
        Table {
            entries: entries.into_iter().collect(),
        }
    }

    fn node(&mut self, node: &Spanned<DeValue<'_>>) -> Node {
        let range = node.span();
        let span = Span::new(self.file, range.start, range.end);
        let value = match node.get_ref() {
            DeValue::String(text) => return self.string(text, range),
            DeValue::Integer(number) => {
                let read = i64::from_str_radix(number.as_str(), number.radix());
                Branch::Integer(self.number(read.ok(), span))
            }
            DeValue::Float(number) => {
                let read = number.as_str().parse::<f64>();
                Branch::Float(self.number(read.ok(), span))
            }
            DeValue::Boolean(truth) => Branch::Boolean(*truth),
            DeValue::Datetime(date) => Branch::Date(date.to_string()),
            DeValue::Array(items) => {
                Branch::List(items.iter().map(|item| self.node(item)).collect())
            }
            DeValue::Table(table) => Branch::Table(self.table(table)),
        };
        Node { span, value }
    }

    fn string(&self, text: &str, range: std::ops::Range<usize>) -> Node {
        Node {
            span: self.content(range),
            value: Branch::Text(text.to_owned()),
        }
    }

    fn number<T: Default>(&mut self, read: Option<T>, span: Span) -> T {
        read.unwrap_or_else(|| {
            let message = "number is too large".to_owned();
            self.errors.push(TomlError {
                message,
                span,
                earlier: None,
            });
            T::default()
        })
    }

    /// Returns the range between the quotes, so that parts of a string can be located and replaced. A string that is not
    /// closed, which is a syntax error, has no range between quotes.
    fn content(&self, range: std::ops::Range<usize>) -> Span {
        let raw = self.text.get(range.clone()).unwrap_or("");
        let quote = ["\"\"\"", "'''", "\"", "'"].into_iter().find(|quote| {
            raw.len() >= 2 * quote.len() && raw.starts_with(quote) && raw.ends_with(quote)
        });
        let margin = quote.map_or(0, str::len);
        Span::new(self.file, range.start + margin, range.end - margin)
    }
}
