//! The binary layout of a type, and the check that it has one.

use asmotion_datum::{Schema, Shape};

use crate::error::UnsupportedTypeError;

/// The binary layout of a type, as RTT's `mqueue` transport defines it. Scalars have the machine's byte order; a list
/// is a 64-bit count followed by its elements; an array consists of its elements, and a record of its fields in order,
/// without padding.
#[derive(Debug, Clone, PartialEq)]
pub struct QueueLayout {
    schema: Schema,
    /// Size in bytes if all lists are empty.
    min_size: usize,
    has_lists: bool,
}

impl QueueLayout {
    /// The layout of a type.
    ///
    /// # Errors
    /// An error if the type has no layout: text, options and unknown types cannot be sent.
    pub fn of(schema: &Schema) -> Result<Self, UnsupportedTypeError> {
        check(schema, "")?;
        Ok(Self {
            min_size: min_size(&schema.shape),
            has_lists: has_lists(schema),
            schema: schema.clone(),
        })
    }

    /// Size of a message in bytes; `None` if it depends on the lengths of lists.
    pub fn size(&self) -> Option<usize> {
        (!self.has_lists).then_some(self.min_size)
    }

    /// Size of a message in bytes, or `default` if it depends on the lengths of lists.
    pub fn size_or(&self, default: usize) -> usize {
        self.size().unwrap_or(default)
    }

    /// Schema of the message type.
    pub fn schema(&self) -> &Schema {
        &self.schema
    }
}

/// Checks that all parts of a type have a layout.
fn check(schema: &Schema, path: &str) -> Result<(), UnsupportedTypeError> {
    match &schema.shape {
        Shape::Any | Shape::Text | Shape::Option(_) => Err(UnsupportedTypeError::NoForm {
            path: path.to_owned(),
            what: schema.to_string(),
        }),
        Shape::List(element) | Shape::Array(element, _) => {
            check(element, path)?;
            match min_size(&element.shape) {
                0 => Err(UnsupportedTypeError::Nothing {
                    path: path.to_owned(),
                    what: element.to_string(),
                }),
                _ => Ok(()),
            }
        }
        Shape::Record(fields) => fields.iter().try_for_each(|field| {
            let path = match path {
                "" => field.name.to_string(),
                path => format!("{path}.{}", field.name),
            };
            check(&field.schema, &path)
        }),
        Shape::Bool
        | Shape::I8
        | Shape::I16
        | Shape::I32
        | Shape::I64
        | Shape::U8
        | Shape::U16
        | Shape::U32
        | Shape::U64
        | Shape::F32
        | Shape::F64 => Ok(()),
    }
}

fn has_lists(schema: &Schema) -> bool {
    matches!(schema.shape, Shape::List(_)) || schema.parts().any(has_lists)
}

/// Minimum size of a value in bytes; 0 for types without a layout.
pub(crate) fn min_size(shape: &Shape) -> usize {
    match shape {
        Shape::Any | Shape::Text | Shape::Option(_) => 0,
        Shape::Bool | Shape::I8 | Shape::U8 => 1,
        Shape::I16 | Shape::U16 => 2,
        Shape::I32 | Shape::U32 | Shape::F32 => 4,
        Shape::I64 | Shape::U64 | Shape::F64 | Shape::List(_) => 8,
        Shape::Array(element, count) => min_size(&element.shape).saturating_mul(*count),
        Shape::Record(fields) => {
            let sizes = fields.iter().map(|field| min_size(&field.schema.shape));
            sizes.fold(0, usize::saturating_add)
        }
    }
}
