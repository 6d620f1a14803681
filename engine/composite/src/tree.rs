//! TOML syntax tree with the source location of every key and value.

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
    pub entries: Vec<Entry>,
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
        let entries = vec![Entry { key, node }];
        Self { entries }
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

    /// Removes the element at `path`: the names of keys separated by dots, and within a list the value itself or the ends of
    /// a table, as in `connections.Joystick.twist -> Rover.twist`.
    ///
    /// # Errors
    ///
    /// The paths of the elements beside the one that is missing.
    pub(crate) fn remove(&mut self, path: &str) -> Result<(), Vec<String>> {
        if let Some(at) = self.entries.iter().position(|it| it.key.value == path) {
            self.entries.remove(at);
            return Ok(());
        }
        let rest = |entry: &Entry| {
            let rest = path.strip_prefix(&entry.key.value)?.strip_prefix('.')?;
            Some(rest.to_owned())
        };
        let mut entries = self.entries.iter_mut();
        let inner = entries.find_map(|entry| Some((rest(entry)?, entry)));
        let Some((rest, entry)) = inner else {
            return Err(self.keys());
        };
        let within = |known: Vec<String>| {
            let key = &entry.key.value;
            let known = known.into_iter();
            known.map(|known| format!("{key}.{known}")).collect()
        };
        match &mut entry.node.value {
            Branch::Table(table) => table.remove(&rest).map_err(within),
            Branch::List(items) => remove_from(items, &rest).map_err(within),
            Branch::Text(_)
            | Branch::Integer(_)
            | Branch::Float(_)
            | Branch::Boolean(_)
            | Branch::Date(_) => Err(within(Vec::new())),
        }
    }

    fn keys(&self) -> Vec<String> {
        let entries = self.entries.iter();
        entries.map(|entry| entry.key.value.clone()).collect()
    }

    /// The strings among the values, including those in lists.
    fn ends(&self) -> Vec<&str> {
        let values = self.entries.iter().map(|entry| &entry.node.value);
        let ends = values.flat_map(|value| {
            if let Branch::List(items) = value {
                items.iter().map(|item| &item.value).collect()
            } else {
                vec![value]
            }
        });
        ends.filter_map(Branch::text).collect()
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

/// Removes the elements of a list that `selector` names: a string by its value, a table by one or two of its ends. An end
/// in a list of several is removed alone.
///
/// # Errors
///
/// The selectors of all elements, if it names none.
fn remove_from(items: &mut Vec<Node>, selector: &str) -> Result<(), Vec<String>> {
    let mut ends = selector.splitn(2, " -> ").map(str::trim);
    let (first, second) = (ends.next().unwrap_or_default(), ends.next());
    let before = items.clone();
    items.retain_mut(|item| {
        let Branch::Table(table) = &mut item.value else {
            return item.value.text() != Some(selector);
        };
        let known = table.ends();
        let is_named = known.contains(&first) && second.is_none_or(|end| known.contains(&end));
        !is_named || second.is_some_and(|end| table.remove_one_of_several(end))
    });
    if *items != before {
        return Ok(());
    }
    let known = items.iter().filter_map(|item| {
        if let Branch::Table(table) = &item.value {
            table.ends().first().copied()
        } else {
            item.value.text()
        }
    });
    Err(known.map(str::to_owned).collect())
}

impl Table {
    /// Removes a string from a list of several. Returns whether there is one.
    fn remove_one_of_several(&mut self, end: &str) -> bool {
        let mut values = self.entries.iter_mut().map(|entry| &mut entry.node.value);
        values.any(|value| {
            let Branch::List(items) = value else {
                return false;
            };
            let count = items.len();
            if count > 1 {
                items.retain(|item| item.value.text() != Some(end));
            }
            items.len() < count
        })
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

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"
[components.Rover]
bind.monitored."wants(ROB1)" = 1
bind.monitored.wants = 2

[[connections]]
from = "Joystick.twist"
to = ["Rover.twist", "Monitor.command"]

[[connections]]
from = "Laser.scan"
to = "Monitor.scan"

[deploy.processes.desk]
components = ["Joystick", "Monitor"]
"#;

    /// The text after the removal of `path`, as a list of lines.
    fn without(path: &str) -> String {
        let (mut table, errors) = parse(FileId(0), TEXT);
        assert!(errors.is_empty());
        table
            .remove(path)
            .unwrap_or_else(|known| panic!("{path}: {known:?}"));
        let mut lines = Vec::new();
        list(&table, "", &mut lines);
        lines.join("\n")
    }

    fn list(table: &Table, prefix: &str, lines: &mut Vec<String>) {
        for entry in &table.entries {
            value(
                &entry.node.value,
                &format!("{prefix}{}", entry.key.value),
                lines,
            );
        }
    }

    fn value(branch: &Branch, path: &str, lines: &mut Vec<String>) {
        if let Branch::Table(table) = branch {
            list(table, &format!("{path}."), lines);
        } else if let Branch::List(items) = branch {
            items
                .iter()
                .for_each(|item| value(&item.value, path, lines));
        } else {
            lines.push(format!("{path} = {}", branch.text().unwrap_or("1")));
        }
    }

    #[test]
    fn a_key_is_removed_by_its_path_whatever_its_name_contains() {
        let left = without("components.Rover.bind.monitored.wants(ROB1)");
        assert!(
            left.contains("monitored.wants =") && !left.contains("ROB1"),
            "{left}"
        );
        let left = without("components.Rover");
        assert!(!left.contains("monitored"), "{left}");
    }

    #[test]
    fn a_connection_is_removed_by_one_end_and_one_of_its_readers_by_both() {
        let left = without("connections.Joystick.twist");
        assert!(
            !left.contains("Rover.twist") && left.contains("Laser.scan"),
            "{left}"
        );
        let left = without("connections.Joystick.twist -> Rover.twist");
        assert!(!left.contains("Rover.twist"), "{left}");
        assert!(
            left.contains("Joystick.twist") && left.contains("Monitor.command"),
            "{left}"
        );
        let left = without("connections.Laser.scan -> Monitor.scan");
        assert!(!left.contains("Laser.scan"), "{left}");
    }

    #[test]
    fn a_word_is_removed_from_a_list() {
        let left = without("deploy.processes.desk.components.Joystick");
        assert!(left.contains("components = Monitor"), "{left}");
        assert!(!left.contains("components = Joystick"), "{left}");
    }

    #[test]
    fn a_missing_element_is_reported_with_those_beside_it() {
        let (mut table, _) = parse(FileId(0), TEXT);
        let before = table.clone();
        let known = table.remove("connections.Laser.scam").unwrap_err();
        assert_eq!(
            known,
            ["connections.Joystick.twist", "connections.Laser.scan"]
        );
        let known = table.remove("components.Rower.bind").unwrap_err();
        assert_eq!(known, ["components.Rover"]);
        assert!(
            table
                .remove("connections.Laser.scan -> Rover.twist")
                .is_err()
        );
        assert_eq!(table, before, "unchanged");
    }
}
