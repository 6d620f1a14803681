//! Message types: those of the build, and those that a composite describes in a file.

use std::collections::BTreeMap;

use datum::{Field, Schema, Shape};
use source::{Diagnostic, Report, Span};

use crate::At;
use crate::catalogue::Catalogue;
use crate::finding::{Finding, Findings};
use crate::nearest::{Nearest, Suggest, nearest_name};
use crate::read::error::has;

/// A file of message types.
#[derive(Clone, Debug)]
pub(crate) struct TypeFile {
    pub definitions: Vec<Definition>,
}

/// `[type."youbot/JointStatus"]`.
#[derive(Clone, Debug)]
pub(crate) struct Definition {
    pub name: At<String>,
    pub fields: Vec<(At<String>, TypeText)>,
}

/// `f64`, `f64[]`, `nav/Event[5]`.
#[derive(Clone, Debug)]
pub(crate) struct TypeText {
    pub base: At<String>,
    pub many: Many,
}

/// How many values a field has.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Many {
    One,
    Any,
    Exactly(usize),
}

#[derive(Debug, thiserror::Error)]
pub(crate) enum TypeError {
    #[error("`{name}` is no type")]
    Unknown { name: String, at: Span, nearest: Option<Nearest> },
    #[error("`{name}` contains itself")]
    Recursive { name: String, at: Span },
    #[error("the types of this composite have more than {MAX_FIELDS} fields, or nest deeper than {MAX_DEPTH}")]
    TooLarge { at: Span },
    #[error("`{name}` is described twice, and differently: {difference}")]
    Twice { name: String, at: Span, first: Span, difference: String },
    #[error("`{name}` looks otherwise in this build: {difference}")]
    Differs { name: String, at: Span, difference: String },
    #[error("`{name}` is a type that this build does not know")]
    NotInBuild { name: String, at: Span, nearest: Option<Nearest> },
    #[error("`{name}` has no field `{field}`")]
    NoField { name: String, field: String, at: Span, known: Vec<String>, declared: Option<Span> },
}

impl Finding for TypeError {
    fn diagnostic(&self) -> Diagnostic {
        match self {
            Self::Unknown { at, nearest, .. } => Diagnostic::error("C110", self)
                .label(*at, "not described in any file of `types`, nor known to this build")
                .help("for example `f64`, `u16[5]`, `string`, `time`, `geometry_msgs/Pose[]`")
                .suggest(*at, nearest),
            Self::Recursive { at, .. } => Diagnostic::error("C111", self)
                .label(*at, "so no message of this type ever ends"),
            Self::TooLarge { at } => Diagnostic::error("C116", self)
                .label(*at, "given up here")
                .help("send what is that large as bytes, or by name"),
            Self::Twice { at, first, .. } => Diagnostic::error("C112", self)
                .label(*at, "described again here")
                .label(*first, "described here"),
            Self::Differs { at, .. } => Diagnostic::error("C113", self)
                .label(*at, "described here")
                .help("leave the description out: the build knows the type"),
            Self::NotInBuild { at, nearest, .. } => Diagnostic::warning("C114", self)
                .label(*at, "its fields cannot be checked")
                .help("describe it in a file under `composite.types`")
                .suggest(*at, nearest),
            Self::NoField { field, at, known, declared, .. } => {
                let nearest = nearest_name(field, known.iter().map(String::as_str));
                let known = known.iter().map(String::as_str);
                let diagnostic = Diagnostic::error("C115", self).label(*at, "no such field");
                let diagnostic = match declared {
                    Some(declared) => diagnostic.label(*declared, "the type is described here"),
                    None => diagnostic,
                };
                diagnostic.suggest_or(*at, &nearest, has("fields", known))
            }
        }
    }
}

/// All types a composite can name.
pub(crate) struct Types<'c> {
    described: BTreeMap<String, (Span, Schema)>,
    catalogue: &'c dyn Catalogue,
}

impl<'c> Types<'c> {
    /// The types of the build and of these files.
    pub(crate) fn new<'f>(
        files: impl IntoIterator<Item = &'f TypeFile>,
        catalogue: &'c dyn Catalogue,
        report: &mut Report,
    ) -> Self {
        let mut definitions: BTreeMap<&str, Vec<&Definition>> = BTreeMap::new();
        for definition in files.into_iter().flat_map(|file| &file.definitions) {
            definitions.entry(&definition.name).or_default().push(definition);
        }
        let mut builder =
            Builder { definitions: &definitions, catalogue, report, open: Vec::new(), fields: 0 };
        let mut described = BTreeMap::new();
        for (name, all) in &definitions {
            let schemas: Vec<_> =
                all.iter().map(|definition| (*definition, builder.record(definition))).collect();
            builder.agree(&schemas);
            if let Some((definition, schema)) = schemas.into_iter().next() {
                described.insert((*name).to_owned(), (definition.name.span, schema));
            }
        }
        Self { described, catalogue }
    }

    /// What a type looks like, if anybody says.
    pub(crate) fn schema(&self, name: &str) -> Option<Schema> {
        if let Some((_, schema)) = self.described.get(name) {
            return Some(schema.clone());
        }
        let (base, count) = split(name)?;
        let base = match primitive(base) {
            Some(shape) => shape,
            None => match self.described.get(base) {
                Some((_, schema)) => schema.clone(),
                None => self.catalogue.schema(base)?,
            },
        };
        Some(many(base, count))
    }

    /// Whether two names mean one type: `f64` and ROS's `float64` do.
    pub(crate) fn same(&self, one: &str, other: &str) -> bool {
        one == other
            || match (self.schema(one), self.schema(other)) {
                (Some(one), Some(other)) => one.compare(&other).is_ok(),
                _ => false,
            }
    }

    /// Whether a name means this type; what is known by nobody agrees with everything.
    pub(crate) fn means(&self, name: &str, schema: &Schema) -> bool {
        let known_by_name = schema.shape == Shape::Any;
        if known_by_name {
            return schema.name.is_empty() || schema.name == name;
        }
        name == schema.to_string()
            || self.schema(name).is_some_and(|named| named.compare(schema).is_ok())
    }

    /// Where a type is described.
    pub(crate) fn declared(&self, name: &str) -> Option<Span> {
        self.described.get(name).map(|(span, _)| *span)
    }

    /// Says that nobody knows the type, if so.
    pub(crate) fn known(&self, name: &str, at: Span, report: &mut Report) {
        if self.schema(name).is_none() {
            let messages = self.catalogue.messages();
            let known = self.described.keys().chain(&messages).map(String::as_str);
            let nearest = nearest_name(name, known);
            report.found(TypeError::NotInBuild { name: name.to_owned(), at, nearest });
        }
    }

    /// The schema at a path into a message, or the finding that there is none.
    pub(crate) fn field(
        &self,
        name: &str,
        path: &crate::model::Path,
    ) -> Result<Option<Schema>, TypeError> {
        self.steps(name, &path.steps)
    }

    /// The same for the steps of a path.
    pub(crate) fn steps(
        &self,
        name: &str,
        steps: &[At<String>],
    ) -> Result<Option<Schema>, TypeError> {
        match self.schema(name) {
            Some(schema) => self.within(schema, steps),
            None => Ok(None),
        }
    }

    /// The same inside a message whose schema is known.
    pub(crate) fn within(
        &self,
        mut schema: Schema,
        steps: &[At<String>],
    ) -> Result<Option<Schema>, TypeError> {
        for step in steps {
            schema = match &schema.shape {
                Shape::Any => return Ok(None),
                Shape::Record(fields) => {
                    match fields.iter().find(|field| field.name == step.value.as_str()) {
                        Some(field) => field.schema.clone(),
                        None => return Err(self.no_field(&schema, step, fields)),
                    }
                }
                Shape::List(item) | Shape::Array(item, _)
                    if step.chars().all(|digit| digit.is_ascii_digit()) =>
                {
                    item.as_ref().clone()
                }
                Shape::Option(inner) => inner.as_ref().clone(),
                _ => return Err(self.no_field(&schema, step, &[])),
            };
        }
        Ok(Some(schema))
    }

    fn no_field(&self, schema: &Schema, step: &At<String>, fields: &[Field]) -> TypeError {
        TypeError::NoField {
            name: schema.to_string(),
            field: step.value.clone(),
            at: step.span,
            known: fields.iter().map(|field| field.name.to_string()).collect(),
            declared: self.declared(&schema.name),
        }
    }
}

/// Puts schemas together out of descriptions.
struct Builder<'d, 'c, 'r> {
    definitions: &'d BTreeMap<&'d str, Vec<&'d Definition>>,
    catalogue: &'c dyn Catalogue,
    report: &'r mut Report,
    /// The descriptions that are being put together, outermost first.
    open: Vec<&'d str>,
    /// How many fields were put together so far, counting a type each time it is used.
    fields: usize,
}

/// Schemas are trees, so a few lines can describe a tree of any size.
const MAX_FIELDS: usize = 100_000;

/// Deeper messages are nobody's intention.
const MAX_DEPTH: usize = 32;

impl<'d> Builder<'d, '_, '_> {
    fn record(&mut self, definition: &'d Definition) -> Schema {
        let before = self.fields;
        self.fields += definition.fields.len();
        if self.fields > MAX_FIELDS || self.open.len() > MAX_DEPTH {
            if before <= MAX_FIELDS {
                self.report.found(TypeError::TooLarge { at: definition.name.span });
                self.fields = MAX_FIELDS + 1;
            }
            return Schema::opaque(definition.name.value.clone());
        }
        self.open.push(&definition.name);
        let fields = definition.fields.iter().map(|(name, text)| Field {
            name: name.value.clone().into(),
            doc: "".into(),
            schema: self.value(text),
        });
        let fields = fields.collect();
        self.open.pop();
        Schema { name: definition.name.value.clone().into(), shape: Shape::Record(fields) }
    }

    fn value(&mut self, text: &TypeText) -> Schema {
        let base = match (primitive(&text.base), self.definitions.get_key_value(text.base.as_str()))
        {
            (Some(schema), _) => schema,
            (None, Some((name, all))) => self.described(name, all, text.base.span),
            (None, None) => match self.catalogue.schema(&text.base) {
                Some(schema) => schema,
                None => self.unknown(text),
            },
        };
        many(base, text.many)
    }

    fn described(&mut self, name: &'d str, all: &[&'d Definition], at: Span) -> Schema {
        if self.open.contains(&name) {
            self.report.found(TypeError::Recursive { name: name.to_owned(), at });
            return Schema::opaque(name.to_owned());
        }
        match all.first() {
            Some(definition) => self.record(definition),
            None => Schema::opaque(name.to_owned()),
        }
    }

    fn unknown(&mut self, text: &TypeText) -> Schema {
        let messages = self.catalogue.messages();
        let primitives = PRIMITIVES.iter().map(|(name, _)| *name);
        let known = self.definitions.keys().copied().chain(primitives);
        let known = known.chain(messages.iter().map(String::as_str));
        let nearest = nearest_name(&text.base, known);
        let At { value: name, span: at } = text.base.clone();
        self.report.found(TypeError::Unknown { name: name.clone(), at, nearest });
        Schema::opaque(name)
    }

    /// Descriptions of one type say the same, and the same as the build.
    fn agree(&mut self, all: &[(&Definition, Schema)]) {
        let Some(((first, schema), others)) = all.split_first() else {
            return;
        };
        let name = &first.name.value;
        for (other, second) in others {
            if let Err(difference) = schema.compare(second) {
                self.report.found(TypeError::Twice {
                    name: name.clone(),
                    at: other.name.span,
                    first: first.name.span,
                    difference: difference.to_string(),
                });
            }
        }
        if let Some(built) = self.catalogue.schema(name)
            && let Err(difference) = schema.compare(&built)
        {
            let (at, difference) = (first.name.span, difference.to_string());
            self.report.found(TypeError::Differs { name: name.clone(), at, difference });
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

/// Splits `f64[5]`; `None` where the brackets make no sense.
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

/// The types that are no messages, by our names and by those of ROS.
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

fn primitive(name: &str) -> Option<Schema> {
    if name == "time" {
        let field = |name: &'static str, shape| Field {
            name: name.into(),
            doc: "".into(),
            schema: Schema::plain(shape),
        };
        let fields = vec![field("sec", Shape::I32), field("nanosec", Shape::U32)];
        return Some(Schema::record("builtin_interfaces/Time", fields));
    }
    let found = PRIMITIVES.iter().find(|(known, _)| *known == name);
    found.map(|(_, shape)| Schema::plain(shape.clone()))
}
