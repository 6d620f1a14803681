//! Translation of message types into programming languages.

use super::cpp::Cpp;
use super::python::Python;
use super::types::{InterfaceType, MessageTypes, RecordType};
use super::typescript::TypeScript;

/// A programming language into which message types are translated.
pub trait TargetLanguage {
    /// Lines before the types. `title` says what they are, `command` what generated them.
    fn head(&self, types: &MessageTypes, title: &str, command: &str) -> String;

    /// The class of a record.
    fn record(&self, record: &RecordType, types: &MessageTypes) -> String;

    /// The class of an interface.
    fn interface(&self, interface: &InterfaceType, types: &MessageTypes) -> String;

    /// Lines between two classes.
    fn gap(&self) -> &'static str {
        "\n"
    }
}

/// The languages, by their flags of `asmotion describe`.
pub const LANGUAGES: &[(&str, &dyn TargetLanguage)] = &[
    ("python", &Python),
    ("typescript", &TypeScript),
    ("cpp", &Cpp),
];

/// Returns the text of a source file with all types.
pub fn source(
    types: &MessageTypes,
    language: &dyn TargetLanguage,
    title: &str,
    command: &str,
) -> String {
    let records = types.records.iter();
    let records = records.map(|record| language.record(record, types));
    let interfaces = types.interfaces.iter();
    let interfaces = interfaces.map(|interface| language.interface(interface, types));
    let mut text = language.head(types, title, command);
    for class in records.chain(interfaces) {
        text.push_str(language.gap());
        text.push_str(&class);
    }
    text
}

/// A name as an identifier: with `_` for characters that identifiers lack, and after one that is a keyword.
pub(super) fn identifier(name: &str, keywords: &[&str]) -> String {
    let usable = |character: char| character.is_ascii_alphanumeric() || character == '_';
    let mut identifier: String = name
        .chars()
        .map(|character| if usable(character) { character } else { '_' })
        .collect();
    if !identifier.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_') {
        identifier.insert(0, '_');
    }
    if keywords.contains(&identifier.as_str()) {
        identifier.push('_');
    }
    identifier
}

/// A text in double quotes, as in JSON, which is also a literal of the languages.
pub(super) fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}
