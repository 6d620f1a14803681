//! Property files: the property values of one component as TOML, corresponding to RTT's CPF files.
//!
//! ```toml
//! # 0.0 to 5.0 m/s: cruise speed
//! speed_mps = 0.6
//! ```

use crate::codes::c028::UnknownProperty;
use asmotion_component::declaration::{Declaration, PropertyDeclaration};
use asmotion_datum::Datum;
use asmotion_diagnostics::{Report, Sources};
use toml_edit::DocumentMut;

use crate::finding::Findings;
use crate::nearest::nearest_name;
use crate::property::lawful;
use crate::read;
use crate::scope::SubstitutionNotes;
use crate::table::toml;
use crate::tree::Table;
use crate::value::SettingValue;

/// Property values in declaration order.
pub type PropertyFileValues = Vec<(String, Datum)>;

/// A parsed property file.
pub struct PropertyFile {
    /// Source text; diagnostics refer to it.
    pub sources: Sources,
    /// All diagnostics of the file.
    pub report: Report,
    /// Valid properties of the file.
    pub properties: PropertyFileValues,
    /// Declared properties that the file does not contain.
    pub missing: Vec<String>,
}

/// Reads a property file of a component; reports unknown names, wrong types and values out of range.
pub fn read(path: &str, text: &str, component: &str, declared: &Declaration) -> PropertyFile {
    let mut sources = Sources::new();
    let file = sources.add(path, text);
    let (table, report) = read::tree(file, path, text);
    let mut read = of_tree(&table.unwrap_or_default(), component, declared);
    read.report.extend(report);
    PropertyFile { sources, ..read }
}

/// Reads properties from a tree, which may originate from another file format.
pub fn of_tree(table: &Table, component: &str, declared: &Declaration) -> PropertyFile {
    let mut notes = SubstitutionNotes::default();
    let mut properties = PropertyFileValues::new();
    for entry in &table.entries {
        let name = &entry.key;
        let Some(property) = declared.property(name) else {
            let known: Vec<_> = declared
                .properties
                .iter()
                .map(|it| it.name.clone())
                .collect();
            notes.found(UnknownProperty::InFile {
                component: component.to_owned(),
                name: name.value.clone(),
                at: name.span,
                nearest: nearest_name(name, known.iter().map(String::as_str)),
                known,
            });
            continue;
        };
        let value = literal(SettingValue::of(&entry.node.value));
        if let Some(value) = lawful(property, value, Some(entry.node.span), &mut notes) {
            properties.push((name.value.clone(), value.datum()));
        }
    }
    let names = declared.properties.iter().map(|it| &it.name);
    let missing = names.filter(|name| table.get(name).is_none());
    PropertyFile {
        sources: Sources::new(),
        report: notes.report,
        properties,
        missing: missing.cloned().collect(),
    }
}

/// Unescapes `$$`, which denotes a dollar sign in composite files.
fn literal(value: SettingValue) -> SettingValue {
    match value {
        SettingValue::Text(text) => SettingValue::Text(text.replace("$$", "$")),
        SettingValue::List(items) => SettingValue::List(items.into_iter().map(literal).collect()),
        SettingValue::Record(fields) => {
            let fields = fields.into_iter();
            SettingValue::Record(fields.map(|(name, it)| (name, literal(it))).collect())
        }
        SettingValue::Boolean(_)
        | SettingValue::Integer(_)
        | SettingValue::Real(_)
        | SettingValue::Secret(_) => value,
    }
}

/// Writes the properties of a component, each preceded by a comment with its description.
pub fn write(declared: &Declaration, properties: &PropertyFileValues) -> String {
    let mut file = DocumentMut::new();
    for (name, value) in properties {
        // TOML has no null value
        let Some(value) = SettingValue::of_datum(value) else {
            continue;
        };
        file.insert(name, toml_edit::value(toml(&value)));
        if let (Some(property), Some(mut key)) = (declared.property(name), file.key_mut(name)) {
            let about = about(property);
            key.leaf_decor_mut().set_prefix(about);
        }
    }
    file.to_string()
}

/// Formats the range, unit and description of a property.
fn about(property: &PropertyDeclaration) -> String {
    let range = property.range.as_ref();
    let range = range.map(|(least, greatest)| format!("{least} to {greatest}"));
    let unit = Some(property.unit.clone()).filter(|unit| !unit.is_empty());
    let lawful: Vec<String> = range.into_iter().chain(unit).collect();
    let doc = property.doc.replace('\n', " ");
    if lawful.is_empty() {
        format!("# {doc}\n")
    } else {
        format!("# {doc} ({})\n", lawful.join(" "))
    }
}

/// Returns the differing properties of a file and a running component: name, value in the file, current value.
pub fn difference<'a>(
    file: &'a PropertyFileValues,
    running: &'a PropertyFileValues,
) -> Vec<(&'a str, &'a Datum, &'a Datum)> {
    let pairs = file.iter().filter_map(|(name, value)| {
        let (_, there) = running.iter().find(|(known, _)| known == name)?;
        Some((&**name, value, there))
    });
    pairs
        .filter(|(_, file, there)| !same(file, there))
        .collect()
}

/// Returns whether two values are equal, regardless of their numeric representation.
fn same(one: &Datum, other: &Datum) -> bool {
    SettingValue::of_datum(one) == SettingValue::of_datum(other)
}
