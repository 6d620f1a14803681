//! TOML text as a tree in which every key and every value knows its place.

use asmotion_diagnostics::{FileId, Span};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::at::At;

/// A value of a TOML file and its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Where it stands; for a `[table]` its header.
    pub span: Span,
    /// What stands there.
    pub value: Branch,
}

/// What can stand at a place of a TOML file.
#[derive(Clone, Debug, PartialEq)]
pub enum Branch {
    /// A text.
    Text(String),
    /// A whole number.
    Integer(i64),
    /// A number with a fraction.
    Float(f64),
    /// `true` or `false`.
    Boolean(bool),
    /// A date or a time of day, as written.
    Date(String),
    /// A list.
    List(Vec<Node>),
    /// A table, inline or not.
    Table(Table),
}

/// The keys of a table in the order of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Keys and values.
    pub entries: Vec<Entry>,
}

/// A key of a table and its value.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The key.
    pub key: At<String>,
    /// Its value.
    pub node: Node,
}

impl Table {
    /// A table with one key.
    pub(crate) fn short(key: &str, node: &Node) -> Self {
        let (key, node) = (At::new(key.to_owned(), node.span), node.clone());
        let entries = vec![Entry { key, node }];
        Self { entries }
    }

    /// The value of a key.
    pub fn get(&self, key: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.key.value == key)
    }

    /// Lays another table over this one: tables of one name become one, anything else takes the place of what was
    /// there.
    pub fn lay(&mut self, over: Self) {
        for entry in over.entries {
            let mut known = self.entries.iter_mut();
            match known.find(|known| known.key.value == entry.key.value) {
                Some(known) => known.lay(entry),
                None => self.entries.push(entry),
            }
        }
    }

    /// Gives a key a table as its value; a key that is new is at that place.
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
    /// What it is, for people: "a string", "a list".
    pub fn describe(&self) -> &'static str {
        match self {
            Self::Text(_) => "a string",
            Self::Integer(_) => "an integer",
            Self::Float(_) => "a number",
            Self::Boolean(_) => "a Boolean",
            Self::Date(_) => "a date",
            Self::List(_) => "a list",
            Self::Table(_) => "a table",
        }
    }
}

/// Why a text is not TOML.
pub(crate) struct TomlError {
    pub message: String,
    pub span: Span,
    /// The same key or header further up, where the finding is a duplicate.
    pub earlier: Option<Span>,
}

/// Reads TOML: as much of the tree as can be understood, and every place that cannot.
pub(crate) fn parse(file: FileId, text: &str) -> (Table, Vec<TomlError>) {
    let (root, errors) = DeTable::parse_recoverable(text);
    let mut grower = Grower {
        file,
        text,
        errors: Vec::new(),
    };
    // up to where a second table of one name reaches: its keys clash only because of that
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

/// The first line that is the same `[header]` as the one around `offset`: the parser reports a
/// duplicate without the place of the original.
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

/// Turns the parser's tree, which borrows the text and has lost the order, into ours.
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
        Table { entries }
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

    /// The characters between the quotes, so that a part of a text can be pointed at and replaced.
    fn content(&self, range: std::ops::Range<usize>) -> Span {
        let raw = self.text.get(range.clone()).unwrap_or("");
        let quote = ["\"\"\"", "'''", "\"", "'"]
            .into_iter()
            .find(|quote| raw.len() >= 2 * quote.len() && raw.starts_with(quote));
        let margin = quote.map_or(0, str::len);
        Span::new(self.file, range.start + margin, range.end - margin)
    }
}
