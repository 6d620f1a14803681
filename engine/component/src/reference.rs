//! Renders a component's declaration as Markdown tables, for the README of its folder.

use std::fmt::{self, Write};

use asmotion_datum::Datum;

use crate::declaration::{Declaration, OperationDeclaration, PropertyDeclaration};

impl Declaration {
    /// Ports, services, references and properties as Markdown tables, in the order of declaration.
    ///
    /// A test compares these tables with the README, so that the two lists cannot diverge.
    pub fn tables(&self) -> String {
        let mut text = String::new();
        // cannot fail: the target is a string
        let _ = write_ports(&mut text, self);
        let _ = write_properties(&mut text, &self.properties);
        text
    }
}

fn write_ports(text: &mut String, of: &Declaration) -> fmt::Result {
    text.push_str("| port | type | |\n|---|---|---|\n");
    for (direction, ports) in [("in", &of.inputs), ("out", &of.outputs)] {
        for port in ports {
            let (name, kind, doc) = (&port.name, &port.schema.name, cell(&port.doc));
            let optional = if port.optional { " (optional)" } else { "" };
            writeln!(
                text,
                "| {direction} `{name}`{optional} | `{kind}` | {doc} |"
            )?;
        }
    }
    for service in &of.services {
        let (name, doc) = (&service.name, cell(&service.doc));
        let kind = operations(&service.interface, &service.operations);
        writeln!(text, "| service `{name}` | {kind} | {doc} |")?;
    }
    for reference in &of.references {
        let (name, doc) = (&reference.name, cell(&reference.doc));
        let optional = if reference.optional {
            " (optional)"
        } else {
            ""
        };
        let kind = operations(&reference.interface, &reference.operations);
        writeln!(text, "| reference `{name}`{optional} | {kind} | {doc} |")?;
    }
    Ok(())
}

fn write_properties(text: &mut String, properties: &[PropertyDeclaration]) -> fmt::Result {
    if !properties.is_empty() {
        text.push_str("\n| property | default | range | |\n|---|---|---|---|\n");
    }
    for property in properties {
        let (name, doc) = (&property.name, cell(&property.doc));
        let (default, range) = (default(property), range(property));
        writeln!(text, "| `{name}` | {default} | {range} | {doc} |")?;
    }
    Ok(())
}

fn operations(interface: &str, operations: &[OperationDeclaration]) -> String {
    let names: Vec<_> = operations.iter().map(|it| it.name.as_str()).collect();
    format!("`{interface}`: `{}`", names.join("`, `"))
}

fn default(property: &PropertyDeclaration) -> String {
    let written = match property.default.as_text() {
        Some("") => "\"\"".to_owned(),
        Some(text) => format!("`{text}`"),
        None => property.default.to_string(),
    };
    let space = if property.unit.is_empty() { "" } else { " " };
    format!("{written}{space}{}", property.unit)
}

/// The range, or the list of choices; empty without a limit.
fn range(property: &PropertyDeclaration) -> String {
    if let Some((least, greatest)) = &property.range {
        return format!("{least} … {greatest}");
    }
    let words: Vec<_> = property.choices.iter().filter_map(Datum::as_text).collect();
    words.join(", ")
}

/// A description, escaped for a table cell.
fn cell(doc: &str) -> String {
    doc.replace('\n', "<br>").replace('|', "\\|")
}
