//! Message types of the executable and of type files.

mod alone;
mod build;
mod read;

use crate::codes::c114::TypeNotInBuild;
use crate::codes::c115::UnknownField;
use std::collections::BTreeMap;

use asmotion_component::BusHealth;
use asmotion_datum::{Message, OutlineKey, Schema, Shape};
use asmotion_derive::Table;
use asmotion_diagnostics::{Report, Span};

pub use self::alone::open_types;
use self::build::Builder;
pub(crate) use self::read::read;
use crate::at::At;
use crate::catalogue::Catalogue;
use crate::finding::Findings;
use crate::nearest::{Nearest, nearest_name};
use crate::table::Dialect;

/// Message types defined by the engine itself.
fn own(name: &str) -> Option<Schema> {
    (name == BusHealth::NAME).then(|| BusHealth::schema().clone())
}

/// A file of message types.
#[derive(Clone, Debug, Table)]
#[table(of = "a file of types")]
pub(crate) struct TypeFile {
    /// Dialect and version of the file.
    #[key(needed, example = "\"composite-types/1\"")]
    #[expect(dead_code, reason = "read for what is wrong with it alone")]
    pub schema: Option<Dialect>,
    /// Message types by name.
    #[key(name = "type", example = "{ }")]
    pub definitions: Vec<Definition>,
}

/// A message type.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a type",
    example = "{ fields = { stamp = \"time\", position = \"f64[5]\" } }"
)]
pub(crate) struct Definition {
    /// Name of the type, such as `youbot/JointStatus`.
    #[key(entry = any)]
    pub name: At<String>,
    /// Description.
    #[key(example = "\"Positions of the joints\"")]
    #[expect(dead_code, reason = "for people")]
    pub doc: Option<At<String>>,
    /// Fields with their types: a name, a list `name[]` or an array `name[5]`.
    #[key(needed, example = "{ stamp = \"time\", position = \"f64[5]\" }")]
    pub fields: Vec<FieldText>,
}

/// A field and its type.
#[derive(Clone, Debug)]
pub(crate) struct FieldText {
    pub name: At<String>,
    /// `None` if it is malformed, which has been reported.
    pub text: Option<TypeText>,
}

/// A type expression such as `f64`, `f64[]` or `nav/Event[5]`.
#[derive(Clone, Debug)]
pub(crate) struct TypeText {
    pub base: At<String>,
    pub many: Many,
}

/// Multiplicity of a field.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Many {
    One,
    Any,
    Exactly(usize),
}

/// All message types visible in a composite.
pub struct Types<'c> {
    described: BTreeMap<String, (Span, Schema)>,
    catalogue: &'c dyn Catalogue,
}

impl<'c> Types<'c> {
    /// Combines the types of the catalogue with those of the given files.
    pub(crate) fn new<'f>(
        files: impl IntoIterator<Item = &'f TypeFile>,
        catalogue: &'c dyn Catalogue,
        report: &mut Report,
    ) -> Self {
        let mut definitions: BTreeMap<&str, Vec<&Definition>> = BTreeMap::new();
        for definition in files.into_iter().flat_map(|file| &file.definitions) {
            definitions
                .entry(&definition.name)
                .or_default()
                .push(definition);
        }
        let mut builder = Builder {
            definitions: &definitions,
            catalogue,
            report,
            open: Vec::new(),
            fields: 0,
        };
        let mut described = BTreeMap::new();
        for (name, all) in &definitions {
            let schemas: Vec<_> = all
                .iter()
                .map(|definition| (*definition, builder.record(definition)))
                .collect();
            builder.agree(&schemas);
            if let Some((definition, schema)) = schemas.into_iter().next() {
                described.insert((*name).to_owned(), (definition.name.span, schema));
            }
        }
        Self {
            described,
            catalogue,
        }
    }

    /// Returns the schema of a type; `None` if it is unknown.
    pub fn schema(&self, name: &str) -> Option<Schema> {
        if let Some((_, schema)) = self.described.get(name) {
            return Some(schema.clone());
        }
        let (base, count) = split(name)?;
        let base = match primitive(base) {
            Some(shape) => shape,
            None => match self.described.get(base) {
                Some((_, schema)) => schema.clone(),
                None => own(base).or_else(|| self.catalogue.schema(base))?,
            },
        };
        Some(many(base, count))
    }

    /// Returns whether two names denote the same type, such as `f64` and ROS's `float64`.
    pub(crate) fn same(&self, one: &str, other: &str) -> bool {
        one == other
            || match (self.schema(one), self.schema(other)) {
                (Some(one), Some(other)) => one.compare(&other).is_ok(),
                _ => false,
            }
    }

    /// Returns whether a name denotes this type. Unknown types are compatible with every type.
    pub(crate) fn means(&self, name: &str, schema: &Schema) -> bool {
        let known_by_name = schema.shape == Shape::Any;
        if known_by_name {
            return schema.name.is_empty() || schema.name == name;
        }
        name == schema.to_string()
            || self
                .schema(name)
                .is_some_and(|named| named.compare(schema).is_ok())
    }

    /// Returns the location of the definition; `None` if the type is not defined in a file.
    pub(crate) fn declared(&self, name: &str) -> Option<Span> {
        self.described.get(name).map(|(span, _)| *span)
    }

    /// Reports an unknown type.
    pub(crate) fn known(&self, name: &str, at: Span, report: &mut Report) {
        if self.schema(name).is_none() {
            let messages = self.catalogue.messages();
            let known = self.described.keys().chain(&messages).map(String::as_str);
            let suffix = format!("/{name}");
            let without_package = known.clone().find(|known| known.ends_with(&suffix));
            let nearest = match without_package {
                Some(known) => Some(Nearest {
                    name: known.to_owned(),
                    declared: None,
                }),
                None => nearest_name(name, known),
            };
            report.found(TypeNotInBuild {
                name: name.to_owned(),
                at,
                nearest,
            });
        }
    }

    /// Returns the schema of a message field, or the diagnostic for an unknown field.
    pub(crate) fn field(
        &self,
        name: &str,
        path: &crate::model::MessagePath,
    ) -> Result<Option<Schema>, UnknownField> {
        self.steps(name, &path.steps)
    }

    /// Like `field`, for the steps of a path.
    pub(crate) fn steps(
        &self,
        name: &str,
        steps: &[At<String>],
    ) -> Result<Option<Schema>, UnknownField> {
        match self.schema(name) {
            Some(schema) => self.within(schema, steps),
            None => Ok(None),
        }
    }

    /// Like `steps`, starting from a known schema.
    pub(crate) fn within(
        &self,
        mut schema: Schema,
        steps: &[At<String>],
    ) -> Result<Option<Schema>, UnknownField> {
        for step in steps {
            if schema.shape == Shape::Any {
                return Ok(None);
            }
            let part = schema.part(&step.value);
            schema = part.cloned().ok_or_else(|| self.no_field(&schema, step))?;
        }
        Ok(Some(schema))
    }

    fn no_field(&self, schema: &Schema, step: &At<String>) -> UnknownField {
        let fields = schema.fields();
        UnknownField {
            name: schema.to_string(),
            field: step.value.clone(),
            at: step.span,
            known: fields.iter().map(|field| field.name.to_string()).collect(),
            declared: self.declared(&schema.name),
        }
    }
}

fn many(base: Schema, many: Many) -> Schema {
    match many {
        Many::One => base,
        Many::Any => Schema::many(base, None),
        Many::Exactly(count) => Schema::many(base, Some(count)),
    }
}

/// Splits `f64[5]` into base type and multiplicity; `None` if malformed.
pub(crate) fn split(written: &str) -> Option<(&str, Many)> {
    let (base, many) = match written.split_once('[') {
        None => (written, Many::One),
        Some((base, rest)) => match rest.strip_suffix(']')? {
            "" => (base, Many::Any),
            digits => (base, Many::Exactly(digits.parse().ok()?)),
        },
    };
    (!base.is_empty()).then_some((base, many))
}

/// Primitive types by their own names and those of ROS.
const PRIMITIVES: [(&str, Shape); 22] = [
    ("bool", Shape::Bool),
    ("i8", Shape::I8),
    ("i16", Shape::I16),
    ("i32", Shape::I32),
    ("i64", Shape::I64),
    ("u8", Shape::U8),
    ("u16", Shape::U16),
    ("u32", Shape::U32),
    ("u64", Shape::U64),
    ("f32", Shape::F32),
    ("f64", Shape::F64),
    ("string", Shape::Text),
    ("int8", Shape::I8),
    ("int16", Shape::I16),
    ("int32", Shape::I32),
    ("int64", Shape::I64),
    ("uint8", Shape::U8),
    ("uint16", Shape::U16),
    ("uint32", Shape::U32),
    ("uint64", Shape::U64),
    ("float32", Shape::F32),
    ("float64", Shape::F64),
];

pub(crate) fn primitive(name: &str) -> Option<Schema> {
    if name == "time" {
        let field = |name: &'static str, shape| OutlineKey::new(name, "", Schema::plain(shape));
        let fields = vec![field("sec", Shape::I32), field("nanosec", Shape::U32)];
        return Some(Schema::record("builtin_interfaces/Time", fields));
    }
    let found = PRIMITIVES.iter().find(|(known, _)| *known == name);
    found.map(|(_, shape)| Schema::plain(shape.clone()))
}
