//! The values of the variables of `for`.

use asmotion_diagnostics::Span;

use crate::at::At;
use crate::tree::{Branch, Entry, Node, Table};

/// Limit for the instances of an element.
const MAX_INSTANCES: usize = 10_000;

/// The values of the variables in one instance of an element; at least one.
pub(super) struct ElementInstance {
    /// Names, without `$`, and values.
    variables: Vec<(String, Branch)>,
}

/// Returns the instances that a value of `for` asks for, at least one.
///
/// # Errors
/// The reason that it is no such value.
pub(super) fn instances(range: &Node) -> Result<Vec<ElementInstance>, String> {
    let found = match &range.value {
        Branch::Text(text) => of_text(text)?,
        Branch::List(rows) => rows.iter().map(of_row).collect::<Result<_, _>>()?,
        Branch::Integer(_)
        | Branch::Float(_)
        | Branch::Boolean(_)
        | Branch::Date(_)
        | Branch::Table(_) => {
            return Err(format!("{} is no range", range.value.describe()));
        }
    };
    let names = |it: &ElementInstance| -> Vec<String> {
        let mut names: Vec<_> = it.variables.iter().map(|(name, _)| name.clone()).collect();
        names.sort();
        names
    };
    let Some(first) = found.first().map(names) else {
        return Err("the list is empty".to_owned());
    };
    if found.iter().any(|it| names(it) != first) {
        return Err("its tables have different variables".to_owned());
    }
    if found.len() > MAX_INSTANCES {
        return Err(too_many(found.len()));
    }
    Ok(found)
}

fn too_many(count: impl std::fmt::Display) -> String {
    format!("{count} instances are more than {MAX_INSTANCES}")
}

/// Reads `$r in 1..20` or `$r in north, south`.
fn of_text(text: &str) -> Result<Vec<ElementInstance>, String> {
    let malformed = || format!("`{text}` is no range");
    let (variable, values) = text.split_once(" in ").ok_or_else(malformed)?;
    let name = variable.trim().strip_prefix('$').ok_or_else(malformed)?;
    if !is_name(name) {
        return Err(malformed());
    }
    let instance = |value| ElementInstance {
        variables: vec![(name.to_owned(), value)],
    };
    if let Some((first, last)) = values.split_once("..") {
        let number = |text: &str| text.trim().parse::<i64>().map_err(|_| malformed());
        let (first, last) = (number(first)?, number(last)?);
        if first > last {
            return Err(format!(
                "`{text}` has no values: {first} is greater than {last}"
            ));
        }
        let count = last.abs_diff(first).saturating_add(1);
        if count > MAX_INSTANCES as u64 {
            return Err(too_many(count));
        }
        return Ok((first..=last)
            .map(|it| instance(Branch::Integer(it)))
            .collect());
    }
    let words = values.split(',').map(str::trim);
    let words = words.map(|word| match word {
        "" => Err(malformed()),
        _ => Ok(instance(Branch::Text(word.to_owned()))),
    });
    words.collect()
}

/// Reads the values of the variables of one instance, as in `{ r = "north", x = 1.5 }`.
fn of_row(row: &Node) -> Result<ElementInstance, String> {
    let Branch::Table(table) = &row.value else {
        return Err(format!("{} in its list is no table", row.value.describe()));
    };
    if table.entries.is_empty() {
        return Err("a table without variables is in its list".to_owned());
    }
    let variables = table.entries.iter().map(|Entry { key, node }| {
        let name = key.value.strip_prefix('$').unwrap_or(&key.value);
        if !is_name(name) {
            return Err(format!("`{}` cannot be the name of a variable", key.value));
        }
        if written(&node.value).is_none() {
            let found = node.value.describe();
            return Err(format!(
                "the value of `{name}` is {found}: a variable has a string, a number or a Boolean"
            ));
        }
        Ok((name.to_owned(), node.value.clone()))
    });
    let variables = variables.collect::<Result<_, _>>()?;
    Ok(ElementInstance { variables })
}

fn is_name(text: &str) -> bool {
    text.starts_with(|it: char| it.is_ascii_alphabetic()) && text.chars().all(is_in_name)
}

fn is_in_name(it: char) -> bool {
    it.is_ascii_alphanumeric() || it == '_'
}

/// The text of a value inside of a string; `None` if it has none.
pub(super) fn written(value: &Branch) -> Option<String> {
    match value {
        Branch::Text(text) => Some(text.clone()),
        Branch::Integer(number) => Some(number.to_string()),
        Branch::Float(number) => Some(number.to_string()),
        Branch::Boolean(truth) => Some(truth.to_string()),
        Branch::Date(_) | Branch::List(_) | Branch::Table(_) => None,
    }
}

impl ElementInstance {
    /// Returns the name of the first variable, without `$`.
    pub fn first_variable(&self) -> &str {
        self.variables.first().map_or("", |(name, _)| name)
    }

    /// Returns the names of the variables, without `$`.
    pub fn variables(&self) -> Vec<String> {
        let names = self.variables.iter().map(|(name, _)| name.clone());
        names.collect()
    }

    /// Returns the table of the variables, as a list of them has it.
    pub fn row(&self, at: Span) -> Node {
        let entries = self.variables.iter().map(|(name, value)| Entry {
            key: At::new(name.clone(), at),
            node: Node {
                span: at,
                value: value.clone(),
            },
        });
        let entries = entries.collect();
        Node {
            span: at,
            value: Branch::Table(Table { entries }),
        }
    }

    fn value(&self, name: &str) -> Option<&Branch> {
        let mut variables = self.variables.iter();
        variables
            .find(|(known, _)| known == name)
            .map(|(_, value)| value)
    }

    /// Substitutes the variables in a string. Other names after `$` stay: they are those of bindings.
    pub fn text(&self, text: &str) -> String {
        self.changed(text).unwrap_or_else(|| text.to_owned())
    }

    /// `None` if no variable occurs in the string.
    fn changed(&self, text: &str) -> Option<String> {
        if !text.contains('$') {
            return None;
        }
        let mut parts = text.split('$');
        let mut result = parts.next().unwrap_or_default().to_owned();
        let mut is_changed = false;
        for part in parts {
            let end = part.find(|it| !is_in_name(it)).unwrap_or(part.len());
            let (name, rest) = part.split_at(end);
            match self.value(name).and_then(written) {
                Some(value) => {
                    is_changed = true;
                    result += &value;
                }
                None => {
                    result.push('$');
                    result += name;
                }
            }
            result += rest;
        }
        is_changed.then_some(result)
    }

    /// Substitutes the variables in the keys and strings of a node. A string that is a variable becomes its value.
    pub fn node(&self, pattern: &NodePattern<'_>) -> Node {
        let (node, parts) = match pattern {
            NodePattern::Fixed(node) => return (*node).clone(),
            NodePattern::Changing(node, parts) => (node, parts),
        };
        let value = match &node.value {
            Branch::Text(text) => match text.strip_prefix('$').and_then(|name| self.value(name)) {
                Some(value) => value.clone(),
                None => Branch::Text(self.text(text)),
            },
            Branch::List(_) => Branch::List(parts.iter().map(|it| self.node(it)).collect()),
            Branch::Table(table) => {
                let entries = table.entries.iter().zip(parts);
                let entries = entries.map(|(Entry { key, .. }, part)| Entry {
                    key: At::new(self.text(&key.value), key.span),
                    node: self.node(part),
                });
                Branch::Table(Table {
                    entries: entries.collect(),
                })
            }
            value @ (Branch::Integer(_)
            | Branch::Float(_)
            | Branch::Boolean(_)
            | Branch::Date(_)) => value.clone(),
        };
        let span = node.span;
        Node { span, value }
    }
}

/// A node of which instances are made. Instances share the parts in which no variable occurs.
pub(super) enum NodePattern<'n> {
    /// No variable occurs in it.
    Fixed(&'n Node),
    /// A variable occurs in it, and the nodes of which it consists.
    Changing(&'n Node, Vec<NodePattern<'n>>),
}

impl<'n> NodePattern<'n> {
    /// Creates the pattern for instances that have the variables of `instance`.
    pub fn new(node: &'n Node, instance: &ElementInstance) -> Self {
        let is_changed = |text: &str| instance.changed(text).is_some();
        let part = |node| Self::new(node, instance);
        let (has_variable, parts): (bool, Vec<_>) = match &node.value {
            Branch::Text(text) => (is_changed(text), Vec::new()),
            Branch::List(items) => (false, items.iter().map(part).collect()),
            Branch::Table(table) => {
                let mut keys = table.entries.iter().map(|it| &it.key.value);
                let parts = table.entries.iter().map(|it| part(&it.node));
                (keys.any(|key| is_changed(key)), parts.collect())
            }
            Branch::Integer(_) | Branch::Float(_) | Branch::Boolean(_) | Branch::Date(_) => {
                (false, Vec::new())
            }
        };
        if has_variable || parts.iter().any(|it| !it.is_fixed()) {
            Self::Changing(node, parts)
        } else {
            Self::Fixed(node)
        }
    }

    /// Returns whether no variable occurs in the node, so that all instances are equal to it.
    pub fn is_fixed(&self) -> bool {
        matches!(self, Self::Fixed(_))
    }
}
