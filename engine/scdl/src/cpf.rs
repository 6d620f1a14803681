//! Reads CPF, the XML in which Orocos RTT stores the properties of a component, as if it were a TOML table.

use crate::codes::x003::MissingAttribute;
use crate::codes::x006::UnknownScdlName;
use crate::codes::x007::WrongAttributeValue;
use asmotion_composite::At;
use asmotion_composite::tree::{Branch, Entry, Node, Table};
use asmotion_diagnostics::{Finding, Report, Sources, Span};

use crate::xml::{self, XmlElement};

/// A property file that was read.
pub struct Cpf {
    /// The file's text, which findings refer to.
    pub sources: Sources,
    /// The findings about the file.
    pub report: Report,
    /// The properties, each with its place in the text.
    pub properties: Table,
}

/// Reads a CPF file. `path` is used in messages only.
pub fn cpf(path: &str, text: &str) -> Cpf {
    let mut sources = Sources::new();
    let file = sources.add(path, text);
    let mut report = Report::new();
    let properties = match xml::parse(file, text) {
        Ok(root) => table(&root, &mut report),
        Err(error) => {
            report.push(error.diagnostic());
            Table::default()
        }
    };
    Cpf {
        sources,
        report,
        properties,
    }
}

/// Converts the child elements of an element to a table, by name.
fn table(outer: &XmlElement, report: &mut Report) -> Table {
    let named = outer.children.iter().filter_map(|element| {
        let (name, value) = (name(element), value(element, report)?);
        let Some(key) = name else {
            let missing = MissingAttribute {
                element: element.name.value.clone(),
                attribute: "name",
                at: element.span,
            };
            report.push(missing.diagnostic());
            return None;
        };
        let node = Node {
            span: place(element),
            value,
        };
        Some(Entry { key, node })
    });
    Table {
        entries: named.collect(),
    }
}

/// Converts an element to a value; `None` for elements that are not properties, such as a description.
fn value(element: &XmlElement, report: &mut Report) -> Option<Branch> {
    let kind = attribute(element, "type").map_or("", |kind| &kind.value);
    match (element.name.value.as_str(), kind) {
        ("simple", kind) => simple(element, kind, report),
        ("sequence", _) | ("struct", "array") => {
            let items = element.children.iter().filter_map(|item| {
                let value = value(item, report)?;
                let span = place(item);
                Some(Node { span, value })
            });
            Some(Branch::List(items.collect()))
        }
        ("struct" | "properties", _) => Some(Branch::Table(table(element, report))),
        ("description", _) => None,
        (name, _) => {
            let unknown = UnknownScdlName {
                what: "element of CPF",
                name: name.to_owned(),
                nearest: None,
                at: element.name.span,
            };
            report.push(unknown.diagnostic());
            None
        }
    }
}

fn simple(element: &XmlElement, kind: &str, report: &mut Report) -> Option<Branch> {
    let written = written(element);
    let (value, wanted) = match kind {
        "boolean" => {
            let truth = match written {
                "1" | "true" => Some(true),
                "0" | "false" => Some(false),
                _ => None,
            };
            (truth.map(Branch::Boolean), "`0` or `1`")
        }
        "float" | "double" => {
            let number = written.parse().ok();
            (number.map(Branch::Float), "a number")
        }
        "string" | "char" => (Some(Branch::Text(written.to_owned())), "a string"),
        "octet" | "short" | "ushort" | "long" | "ulong" | "longlong" | "ulonglong" => {
            let number = written.parse().ok();
            (number.map(Branch::Integer), "an integer")
        }
        _ => (None, "a CPF type, as in `double`"),
    };
    if value.is_none() {
        let wrong = WrongAttributeValue {
            name: name(element).map_or_else(String::new, |name| name.value),
            value: written.to_owned(),
            expected: wanted,
            at: place(element),
        };
        report.push(wrong.diagnostic());
    }
    value
}

fn name(element: &XmlElement) -> Option<At<String>> {
    attribute(element, "name").cloned()
}

fn attribute<'e>(element: &'e XmlElement, name: &str) -> Option<&'e At<String>> {
    let mut attributes = element.attributes.iter();
    attributes.find(|it| it.name == name).map(|it| &it.value)
}

/// The text of an element's `<value>`; empty without one.
fn written(element: &XmlElement) -> &str {
    let mut children = element.children.iter();
    let value = children.find(|child| child.name.value == "value");
    value.map_or("", |value| &value.text.value)
}

/// The place of an element's `<value>`, or of the element without one.
fn place(element: &XmlElement) -> Span {
    let mut children = element.children.iter();
    let value = children.find(|child| child.name.value == "value");
    value.map_or(element.span, |value| value.text.span)
}
