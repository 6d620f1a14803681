//! JSON Schema and reference page of the composite dialect. Both are generated from the declarations used by the reader
//! and are therefore consistent with it.

use std::fmt::Write;

use serde_json::{Value as Json, json};

use crate::mission::MissionFile;
use crate::model::Composite;
use crate::table::{Key, Many, Outline, Table};
use crate::types::TypeFile;

/// Returns the JSON Schema of composite files.
pub fn composite() -> Json {
    let mut schema = document("a composite of asmotion", &Composite::outline());
    // a composite with a base inherits its name
    schema["required"] = json!(["schema"]);
    schema["anyOf"] = json!([{ "required": ["composite"] }, { "required": ["base"] }]);
    // and its components, which it changes, inherit their implementations
    let component = schema.pointer_mut("/properties/components/additionalProperties");
    let required = component
        .and_then(Json::as_object_mut)
        .and_then(|component| component.remove("required"));
    if let Some(required) = required {
        let component = json!({ "additionalProperties": { "required": required } });
        schema["if"] = json!({ "not": { "required": ["base"] } });
        schema["then"] = json!({ "properties": { "components": component } });
    }
    schema
}

/// Returns the JSON Schema of type files.
pub fn types() -> Json {
    document("message types of asmotion", &TypeFile::outline())
}

/// Returns the JSON Schema of mission files.
pub fn mission() -> Json {
    document("a mission of asmotion", &MissionFile::outline())
}

fn document(title: &str, outline: &Outline) -> Json {
    let mut schema = outline.schema();
    if let Some(schema) = schema.as_object_mut() {
        schema.insert(
            "$schema".to_owned(),
            "http://json-schema.org/draft-07/schema#".into(),
        );
        schema.insert("title".to_owned(), title.into());
    }
    schema
}

/// Returns the reference page in Markdown: all tables with their keys.
pub fn reference() -> String {
    let mut page = String::from(
        "# Keys of composite files\n\nGenerated from the declarations in `engine`; \
         [Composites](composites.md) explains their use. Keys in **bold** are required. `${properties.x}`, \
         `${VARIABLE}` and `${VARIABLE:-default}` are substituted in values of properties, in times, in arguments of \
         bindings and in endpoints; `${\u{2026}_FILE}` is the content of the file it names; `$$` is a dollar sign.\n",
    );
    section(&mut page, "composite/1", "", &Composite::outline());
    section(&mut page, "composite-types/1", "", &TypeFile::outline());
    section(&mut page, "mission/1", "", &MissionFile::outline());
    page
}

fn section(page: &mut String, title: &str, path: &str, outline: &Outline) {
    let doc = outline.doc;
    // writing to a string cannot fail
    let _ = write!(
        page,
        "\n## `{title}`\n\n{doc}\n\n| key | value | default | |\n|---|---|---|---|\n"
    );
    for (key, with) in &outline.keys {
        let _ = writeln!(page, "{}", row(key, *with, outline));
    }
    for (key, _) in &outline.keys {
        let Some(inner) = (key.table)(key) else {
            continue;
        };
        let dot = if path.is_empty() { "" } else { "." };
        let name = match key.many {
            Some(Many::Names) => format!("{path}{dot}{}.<name>", key.name),
            None | Some(Many::OneOrList | Many::List(_) | Many::Tables) => {
                format!("{path}{dot}{}", key.name)
            }
        };
        let title = match key.many {
            Some(Many::Tables) => format!("[[{name}]]"),
            None | Some(Many::OneOrList | Many::List(_) | Many::Names) => format!("[{name}]"),
        };
        section(page, &title, &name, &inner);
    }
}

fn row(key: &Key, with: Option<&str>, outline: &Outline) -> String {
    let needed = key.needed && with.is_none() && !outline.one_of.contains(&key.name);
    let name = if needed {
        format!("**`{}`**", key.name)
    } else {
        format!("`{}`", key.name)
    };
    let with = with.map_or(String::new(), |with| format!(" (with `{with}`)"));
    let default = key
        .default_text()
        .map_or(String::new(), |it| format!("`{it}`"));
    let doc = key.doc.replace('\n', " ");
    format!("| {name}{with} | {} | {default} | {doc} |", value(key))
}

/// Describes the values of a key.
fn value(key: &Key) -> String {
    let one = kind(&(key.schema)(key));
    let unit = match key.unit {
        "" => String::new(),
        unit => format!(", {unit}"),
    };
    match key.many {
        None => format!("{one}{unit}"),
        Some(Many::OneOrList) => format!("{one}, or a list"),
        Some(Many::List(_)) => format!("list of {one}{unit}"),
        Some(Many::Tables) => "list of tables".to_owned(),
        Some(Many::Names) => format!("{one} by name"),
    }
}

fn kind(schema: &Json) -> String {
    if let Some(words) = schema["enum"].as_array() {
        let words = words.iter().filter_map(Json::as_str);
        let words: Vec<String> = words.map(|word| format!("`{word}`")).collect();
        return words.join(" ");
    }
    if let Some(first) = schema["anyOf"].get(0) {
        return kind(first);
    }
    match schema["type"].as_str() {
        Some("string") => "string".to_owned(),
        Some("boolean") => "`true` `false`".to_owned(),
        Some("object") => "table".to_owned(),
        Some("integer" | "number") => match (&schema["minimum"], &schema["maximum"]) {
            (Json::Null, Json::Null) => "number".to_owned(),
            (least, greatest) => format!("{least} \u{2026} {greatest}"),
        },
        _ => "any".to_owned(),
    }
}
