//! The message types and interfaces of a composite or of this build, for translation into programming languages.

use std::collections::BTreeMap;

use asmotion_component::declaration::OperationDeclaration;
use asmotion_composite::Catalogue;
use asmotion_datum::{Datum, Schema, Shape};

use super::Description;

/// Records in an order in which each follows the records that it contains, and interfaces by name.
#[derive(Default)]
pub struct MessageTypes {
    pub records: Vec<RecordType>,
    pub interfaces: Vec<InterfaceType>,
}

/// A record.
pub struct RecordType {
    /// Name of the message type; empty for a record without a name.
    pub name: String,
    /// Name of its class, unique among all records and interfaces.
    pub class: String,
    pub fields: Vec<RecordField>,
}

/// A field of a record.
pub struct RecordField {
    pub name: String,
    /// Description with the unit; may be empty.
    pub doc: String,
    pub data: FieldType,
    /// Value in a new message, if it is not the zero of the type; else null.
    pub initial: Datum,
}

/// The type of a field.
pub enum FieldType {
    Any,
    Bool,
    Integer {
        is_signed: bool,
        bits: u8,
    },
    Float {
        bits: u8,
    },
    Text,
    Option(Box<FieldType>),
    /// A list, of fixed length if there is a number.
    List(Box<FieldType>, Option<usize>),
    /// The record with this index.
    Record(usize),
}

/// A service interface.
pub struct InterfaceType {
    pub name: String,
    /// Name of its class, unique among all records and interfaces.
    pub class: String,
    pub operations: Vec<OperationType>,
}

/// An operation of an interface.
pub struct OperationType {
    pub name: String,
    pub request: FieldType,
    pub response: FieldType,
}

impl MessageTypes {
    /// All messages and interfaces of this build.
    pub fn of_build(build: &dyn Catalogue) -> Self {
        let mut types = Self::default();
        let messages = build.messages();
        for schema in messages.iter().filter_map(|name| build.schema(name)) {
            types.field_type(&schema, "");
        }
        let interfaces = build.interfaces().into_iter();
        let interfaces = interfaces.filter_map(|name| {
            let operations = build.operations(&name)?;
            Some((name, operations))
        });
        types.add_interfaces(interfaces.collect());
        types
    }

    /// The types of the topics, ports, services and references of a composite.
    pub fn of(description: &Description<'_>) -> Self {
        let mut types = Self::default();
        for schema in description.messages() {
            types.field_type(schema, "");
        }
        types.add_interfaces(description.interfaces());
        types
    }

    fn add_interfaces(&mut self, interfaces: BTreeMap<String, Vec<OperationDeclaration>>) {
        for (name, operations) in interfaces {
            let operations = operations.into_iter().map(|operation| OperationType {
                request: self
                    .field_type(&operation.request, &format!("{} request", operation.name)),
                response: self
                    .field_type(&operation.response, &format!("{} response", operation.name)),
                name: operation.name,
            });
            let operations = operations.collect();
            self.interfaces.push(InterfaceType {
                class: class(&name),
                name,
                operations,
            });
        }
        self.tell_apart();
    }

    /// The type of a schema, whose records are added. A record without a name has the class of `place`.
    fn field_type(&mut self, schema: &Schema, place: &str) -> FieldType {
        let integer = |is_signed, bits| FieldType::Integer { is_signed, bits };
        match &schema.shape {
            Shape::Any => FieldType::Any,
            Shape::Bool => FieldType::Bool,
            Shape::I8 => integer(true, 8),
            Shape::I16 => integer(true, 16),
            Shape::I32 => integer(true, 32),
            Shape::I64 => integer(true, 64),
            Shape::U8 => integer(false, 8),
            Shape::U16 => integer(false, 16),
            Shape::U32 => integer(false, 32),
            Shape::U64 => integer(false, 64),
            Shape::F32 => FieldType::Float { bits: 32 },
            Shape::F64 => FieldType::Float { bits: 64 },
            Shape::Text => FieldType::Text,
            Shape::Option(some) => FieldType::Option(Box::new(self.field_type(some, place))),
            Shape::List(element) => {
                FieldType::List(Box::new(self.field_type(element, place)), None)
            }
            Shape::Array(element, count) => {
                FieldType::List(Box::new(self.field_type(element, place)), Some(*count))
            }
            Shape::Record(fields) => {
                let mut known = self.records.iter();
                if let Some(index) =
                    known.position(|it| !it.name.is_empty() && it.name == schema.name)
                {
                    return FieldType::Record(index);
                }
                let class = class(if schema.name.is_empty() {
                    place
                } else {
                    &schema.name
                });
                let fields = fields.iter().map(|field| RecordField {
                    name: field.name.to_string(),
                    doc: field.doc.to_string(),
                    data: self.field_type(&field.schema, &format!("{class} {}", field.name)),
                    initial: field.initial.clone(),
                });
                let fields = fields.collect();
                self.records.push(RecordType {
                    name: schema.name.to_string(),
                    class,
                    fields,
                });
                FieldType::Record(self.records.len() - 1)
            }
        }
    }

    /// Puts the package before classes of the same name, and a number behind those that are still the same.
    fn tell_apart(&mut self) {
        let qualified = |name: &str| class(&name.replace('/', " "));
        for rename in [
            &(|name: &str, _: usize| qualified(name)) as &dyn Fn(&str, usize) -> String,
            &|name, count| format!("{}{count}", qualified(name)),
        ] {
            let mut counts: BTreeMap<String, usize> = BTreeMap::new();
            for (_, class) in self.classes() {
                *counts.entry(class.clone()).or_default() += 1;
            }
            let mut used = 0;
            for (name, class) in self.classes() {
                if counts.get(class).is_some_and(|count| *count > 1) {
                    used += 1;
                    *class = rename(
                        if name.is_empty() {
                            class.as_str()
                        } else {
                            name
                        },
                        used,
                    );
                }
            }
        }
    }

    /// Name and class of every record and interface.
    fn classes(&mut self) -> impl Iterator<Item = (&str, &mut String)> {
        let records = self.records.iter_mut();
        let interfaces = self.interfaces.iter_mut();
        let records = records.map(|it| (it.name.as_str(), &mut it.class));
        records.chain(interfaces.map(|it| (it.name.as_str(), &mut it.class)))
    }
}

/// The last part of a type's name as a class: `Twist` for `geometry_msgs/Twist`, `PathFrom` for `path from`.
fn class(name: &str) -> String {
    let last = name.rsplit('/').next().unwrap_or(name);
    let words = last.split(|character: char| !character.is_ascii_alphanumeric());
    let class: String = words.map(capitalized).collect();
    if class.starts_with(|first: char| first.is_ascii_alphabetic()) {
        class
    } else {
        format!("Type{class}")
    }
}

fn capitalized(word: &str) -> String {
    let mut letters = word.chars();
    let first = letters.next().map(|first| first.to_ascii_uppercase());
    first.into_iter().chain(letters).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use asmotion_datum::OutlineKey;

    fn record(name: &str, fields: Vec<OutlineKey>) -> Schema {
        Schema {
            name: name.to_owned().into(),
            shape: Shape::Record(fields),
        }
    }

    #[test]
    fn its_classes_are_unique_and_follow_their_parts() {
        let inner = record(
            "",
            vec![OutlineKey::new("x", "", Schema::plain(Shape::F64))],
        );
        let state = record("a/State", vec![OutlineKey::new("old part", "", inner)]);
        let other = record(
            "b_c/State",
            vec![OutlineKey::new("state", "", state.clone())],
        );
        let mut types = MessageTypes::default();
        types.field_type(&other, "");
        types.field_type(&state, "");
        let operation = OperationDeclaration {
            name: "set".to_owned(),
            request: state,
            response: Schema::plain(Shape::Bool),
            while_stopped: false,
        };
        types.add_interfaces(BTreeMap::from([("a/2d".to_owned(), vec![operation])]));
        let classes: Vec<&str> = types.records.iter().map(|it| it.class.as_str()).collect();
        assert_eq!(classes, ["StateOldPart", "AState", "BCState"]);
        assert_eq!(types.interfaces[0].class, "Type2d");
    }
}
