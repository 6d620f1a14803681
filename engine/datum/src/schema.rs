//! Schemas: the shape of a type as data, compared before ports are connected, displayed to users, and stored beside
//! recordings.

use std::borrow::Cow;
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::value::{Datum, FieldName};

/// The name and shape of a type.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Schema {
    /// The message type's name, for example `geometry_msgs/Twist`; empty for other types.
    #[serde(default)]
    pub name: FieldName,
    /// Kind of data, with its parts.
    pub shape: Shape,
}

/// The kinds of data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// Known only at run time.
    Any,
    /// A Boolean.
    Bool,
    /// 8-bit signed integer.
    I8,
    /// 16-bit signed integer.
    I16,
    /// 32-bit signed integer.
    I32,
    /// 64-bit signed integer.
    I64,
    /// 8-bit unsigned integer.
    U8,
    /// 16-bit unsigned integer.
    U16,
    /// 32-bit unsigned integer.
    U32,
    /// 64-bit unsigned integer.
    U64,
    /// Single-precision float.
    F32,
    /// Double-precision float.
    F64,
    /// UTF-8 text.
    Text,
    /// An optional value.
    Option(Box<Schema>),
    /// A list of any length.
    List(Box<Schema>),
    /// A list of fixed length.
    Array(Box<Schema>, usize),
    /// Named fields, in order.
    Record(Vec<OutlineKey>),
}

/// A field of a record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OutlineKey {
    /// Name, unique in the record.
    pub name: FieldName,
    /// Description with the unit; may be empty.
    #[serde(default)]
    pub doc: FieldName,
    /// Schema of the field's type.
    pub schema: Schema,
    /// Value in a new message, if it is not the zero of the type; else null.
    #[serde(default, skip_serializing_if = "Datum::is_null")]
    pub initial: Datum,
}

/// The first place where two schemas differ.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}{left} here, {right} there", DifferencePrefix(path))]
pub struct SchemaDifference {
    /// Path of field names to the place; empty for the whole schema.
    pub path: String,
    /// The part of the first schema at this place.
    pub left: String,
    /// The part of the second schema at this place.
    pub right: String,
}

impl Shape {
    /// Tests whether data of this shape are integers, signed or not.
    pub fn is_integer(&self) -> bool {
        let is_signed = matches!(self, Self::I8 | Self::I16 | Self::I32 | Self::I64);
        is_signed || matches!(self, Self::U8 | Self::U16 | Self::U32 | Self::U64)
    }

    /// Tests whether data of this shape are floats.
    pub fn is_float(&self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }

    /// Tests whether data of this shape are numbers.
    pub fn is_number(&self) -> bool {
        self.is_integer() || self.is_float()
    }
}

impl Schema {
    /// A schema without a type name.
    pub fn plain(shape: Shape) -> Self {
        Self {
            name: Cow::Borrowed(""),
            shape,
        }
    }

    /// The schema of a message type.
    pub fn record(name: &'static str, fields: Vec<OutlineKey>) -> Self {
        Self {
            name: Cow::Borrowed(name),
            shape: Shape::Record(fields),
        }
    }

    /// The schema of a type of which only the name is known.
    pub fn opaque(name: impl Into<FieldName>) -> Self {
        Self {
            name: name.into(),
            shape: Shape::Any,
        }
    }

    /// The schema of a list, with a fixed length if `count` is given.
    pub fn many(element: Self, count: Option<usize>) -> Self {
        let element = Box::new(element);
        Self::plain(match count {
            Some(count) => Shape::Array(element, count),
            None => Shape::List(element),
        })
    }

    /// The schemas of the parts: of the fields of a record, in order; otherwise of the value of an option or the element of a
    /// list. Other shapes have no parts.
    pub fn parts(&self) -> impl Iterator<Item = &Self> {
        self.element()
            .into_iter()
            .chain(self.own_fields().iter().map(|field| &field.schema))
    }

    /// As [`parts`](Self::parts), to change them.
    pub fn parts_mut(&mut self) -> impl Iterator<Item = &mut Self> {
        let (mut element, mut fields) = (None, None);
        match &mut self.shape {
            Shape::Option(part) | Shape::List(part) | Shape::Array(part, _) => {
                element = Some(&mut **part);
            }
            Shape::Record(own) => fields = Some(own.iter_mut().map(|field| &mut field.schema)),
            Shape::Any
            | Shape::Bool
            | Shape::I8
            | Shape::I16
            | Shape::I32
            | Shape::I64
            | Shape::U8
            | Shape::U16
            | Shape::U32
            | Shape::U64
            | Shape::F32
            | Shape::F64
            | Shape::Text => {}
        }
        element.into_iter().chain(fields.into_iter().flatten())
    }

    /// The fields of a record, or of an optional record; empty for other shapes.
    pub fn fields(&self) -> &[OutlineKey] {
        self.without_option().own_fields()
    }

    /// The schema of a part, by the name of a field or the index of an element, as in [`Datum::get`]: an optional value has
    /// the parts of its value. Every part of unknown data is unknown. Returns `None` if there is no such part.
    pub fn part(&self, step: &str) -> Option<&Self> {
        let inner = self.without_option();
        if inner.shape == Shape::Any {
            return Some(inner);
        }
        if let Some(element) = inner.element() {
            let index: usize = step.parse().ok()?;
            let is_inside = !matches!(inner.shape, Shape::Array(_, count) if index >= count);
            return is_inside.then_some(element);
        }
        let field = inner.own_fields().iter().find(|field| field.name == step)?;
        Some(&field.schema)
    }

    /// The schema at a path of steps with dots between them; see [`part`](Self::part). The empty path leads to the schema
    /// itself.
    ///
    /// ```
    /// use asmotion_datum::{OutlineKey, Schema, Shape};
    ///
    /// let joint = Schema::record("example/Joint", vec![OutlineKey::new("angle", "rad", Schema::plain(Shape::F64))]);
    /// let arm = Schema::record("example/Arm", vec![OutlineKey::new("joints", "", Schema::many(joint, Some(5)))]);
    /// assert_eq!(arm.part_at("joints.4.angle"), Some(&Schema::plain(Shape::F64)));
    /// assert_eq!(arm.part_at("joints.5.angle"), None);
    /// ```
    pub fn part_at(&self, path: &str) -> Option<&Self> {
        let mut steps = path.split('.').filter(|step| !step.is_empty());
        steps.try_fold(self, |schema, step| schema.part(step))
    }

    /// The schema of the value of an option, at any depth; otherwise the schema itself.
    pub fn without_option(&self) -> &Self {
        if let Shape::Option(some) = &self.shape {
            some.without_option()
        } else {
            self
        }
    }

    fn element(&self) -> Option<&Self> {
        if let Shape::Option(part) | Shape::List(part) | Shape::Array(part, _) = &self.shape {
            Some(part)
        } else {
            None
        }
    }

    fn own_fields(&self) -> &[OutlineKey] {
        if let Shape::Record(fields) = &self.shape {
            fields
        } else {
            &[]
        }
    }

    /// The zero of this shape. For a record it is empty: omitted fields have their initial values.
    pub(crate) fn zero(&self) -> Datum {
        match &self.shape {
            Shape::Any | Shape::Option(_) => Datum::Null,
            Shape::Bool => Datum::Bool(false),
            Shape::I8
            | Shape::I16
            | Shape::I32
            | Shape::I64
            | Shape::U8
            | Shape::U16
            | Shape::U32
            | Shape::U64 => Datum::Int(0),
            Shape::F32 | Shape::F64 => Datum::Float(0.0),
            Shape::Text => Datum::Text(String::new()),
            Shape::List(_) => Datum::List(Vec::new()),
            Shape::Array(element, count) => Datum::List(vec![element.zero(); *count]),
            Shape::Record(_) => Datum::Record(Vec::new()),
        }
    }

    /// Returns the first difference to another schema as an error. Descriptions are ignored; [`Shape::Any`] equals
    /// everything.
    ///
    /// # Errors
    /// The first difference in order of declaration, with the path to it.
    pub fn compare(&self, other: &Self) -> Result<(), SchemaDifference> {
        if self.shape == Shape::Any || other.shape == Shape::Any {
            let named = !self.name.is_empty() && !other.name.is_empty();
            return self.agree(!named || self.name == other.name, other);
        }
        self.agree(self.name == other.name, other)?;
        match (&self.shape, &other.shape) {
            (Shape::List(left), Shape::List(right))
            | (Shape::Option(left), Shape::Option(right)) => {
                left.compare(right).map_err(|there| there.within("*"))
            }
            (Shape::Array(left, n), Shape::Array(right, m)) if n == m => {
                left.compare(right).map_err(|there| there.within("*"))
            }
            (Shape::Record(left), Shape::Record(right)) => compare_fields(left, right),
            (left, right) => self.agree(left == right, other),
        }
    }

    fn agree(&self, agree: bool, other: &Self) -> Result<(), SchemaDifference> {
        if agree {
            return Ok(());
        }
        Err(SchemaDifference {
            path: String::new(),
            left: self.to_string(),
            right: other.to_string(),
        })
    }
}

impl OutlineKey {
    /// A field whose value in a new message is zero.
    pub fn new(name: impl Into<FieldName>, doc: impl Into<FieldName>, schema: Schema) -> Self {
        Self {
            name: name.into(),
            doc: doc.into(),
            schema,
            initial: Datum::Null,
        }
    }

    /// Value of the field in a new message.
    pub(crate) fn initial(&self) -> Datum {
        if self.initial == Datum::Null {
            self.schema.zero()
        } else {
            self.initial.clone()
        }
    }
}

fn compare_fields(left: &[OutlineKey], right: &[OutlineKey]) -> Result<(), SchemaDifference> {
    let name = |field: Option<&OutlineKey>| match field {
        Some(field) => format!("field `{}`", field.name),
        None => "no field".to_owned(),
    };
    for index in 0..left.len().max(right.len()) {
        let (here, there) = (left.get(index), right.get(index));
        match (here, there) {
            (Some(a), Some(b)) if a.name == b.name => {
                a.schema
                    .compare(&b.schema)
                    .map_err(|difference| difference.within(&a.name))?;
            }
            (here, there) => {
                return Err(SchemaDifference {
                    path: String::new(),
                    left: name(here),
                    right: name(there),
                });
            }
        }
    }
    Ok(())
}

impl SchemaDifference {
    fn within(mut self, segment: &str) -> Self {
        self.path = if self.path.is_empty() {
            segment.to_owned()
        } else {
            format!("{segment}.{}", self.path)
        };
        self
    }
}

/// Displays the type name, or the shape if there is none.
impl fmt::Display for Schema {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.name.is_empty() {
            return self.shape.fmt(f);
        }
        f.write_str(&self.name)
    }
}

/// Displays the shape as ROS writes types: `float64[36]`, `string`, `geometry_msgs/Pose[]`.
impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = match self {
            Self::Any => "any",
            Self::Bool => "bool",
            Self::I8 => "int8",
            Self::I16 => "int16",
            Self::I32 => "int32",
            Self::I64 => "int64",
            Self::U8 => "uint8",
            Self::U16 => "uint16",
            Self::U32 => "uint32",
            Self::U64 => "uint64",
            Self::F32 => "float32",
            Self::F64 => "float64",
            Self::Text => "string",
            Self::Option(some) => return write!(f, "{some}?"),
            Self::List(element) => return write!(f, "{element}[]"),
            Self::Array(element, count) => return write!(f, "{element}[{count}]"),
            Self::Record(fields) => return record(f, fields),
        };
        f.write_str(word)
    }
}

fn record(f: &mut fmt::Formatter<'_>, fields: &[OutlineKey]) -> fmt::Result {
    f.write_str("{")?;
    for (index, field) in fields.iter().enumerate() {
        let comma = if index == 0 { "" } else { ", " };
        write!(f, "{comma}{}: {}", field.name, field.schema)?;
    }
    f.write_str("}")
}

/// Displays `pose.position: ` before a difference, or nothing for an empty path.
struct DifferencePrefix<'a>(&'a str);

impl fmt::Display for DifferencePrefix<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            return Ok(());
        }
        write!(f, "`{}`: ", self.0)
    }
}
