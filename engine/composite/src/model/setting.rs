//! Values that may be set from outside: properties, substitutions, amounts.

use asmotion_derive::{Table, Word};
use std::fmt;

use asmotion_diagnostics::Span;

use crate::address::mask;
use crate::at::At;
use crate::tree::Node;

/// A property of the composite, which an integrator may set.
#[derive(Clone, Table)]
#[table(
    of = "a property",
    example = "{ type = \"f64\", default = 0.35, min = 0.0, max = 1.0 }"
)]
pub struct Property {
    /// Its name.
    #[key(entry = thing)]
    pub name: At<String>,
    /// What it holds.
    #[key(name = "type", example = "\"f64\"")]
    pub kind: At<PropertyType>,
    /// Its value unless set from outside; without one it must be set.
    pub default: Option<Node>,
    /// The least value.
    pub min: Option<At<f64>>,
    /// The greatest value.
    pub max: Option<At<f64>>,
    /// What it is for.
    #[key(example = "\"what it is for\"")]
    pub doc: Option<At<String>>,
}

/// What a property holds: one value, or a list of them (`f64[]`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PropertyType {
    /// The type of the value or of the items.
    pub scalar: Scalar,
    /// Whether it is a list.
    pub list: bool,
}

/// The type of one value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum Scalar {
    /// A text.
    #[default]
    #[word("string")]
    Text,
    /// A Boolean.
    #[word("bool")]
    Boolean,
    /// A whole number of 8 bits.
    I8,
    /// A whole number of 16 bits.
    I16,
    /// A whole number of 32 bits.
    I32,
    /// A whole number of 64 bits.
    I64,
    /// A natural number of 8 bits.
    U8,
    /// A natural number of 16 bits.
    U16,
    /// A natural number of 32 bits.
    U32,
    /// A natural number of 64 bits (as far as TOML can write it: 63).
    U64,
    /// A number in single precision.
    F32,
    /// A number in double precision.
    F64,
    /// An address, as in `http://…`, `file:…`.
    Uri,
    /// A file or a directory.
    Path,
    /// A text that is never shown.
    Secret,
}

/// A property of a component or of a nested composite, being set.
#[derive(Clone, Debug)]
pub struct Setting {
    /// The property.
    pub name: At<String>,
    /// Its value; texts in it may hold substitutions.
    pub value: Node,
}

/// A text with substitutions, as in `amqp://${AMQP_USER:-guest}@127.0.0.1`.
#[derive(Clone, PartialEq)]
pub struct Template {
    /// Its parts in order.
    pub pieces: Vec<Piece>,
}

/// A part of a [`Template`].
#[derive(Clone, Debug, PartialEq)]
pub enum Piece {
    /// Text that stands for itself.
    Text(String),
    /// `${properties.name}`.
    Property {
        /// The property of the composite.
        name: String,
        /// Where its name stands.
        span: Span,
    },
    /// `${NAME}` or `${NAME:-default}`.
    Variable {
        /// The environment variable.
        name: String,
        /// What holds where it is not set.
        default: Option<String>,
        /// Where its name stands.
        span: Span,
    },
}

/// Without the default of a secret.
impl fmt::Debug for Property {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let secret = self.kind.value.scalar == Scalar::Secret;
        f.debug_struct("Property")
            .field("name", &self.name)
            .field("kind", &self.kind)
            .field("default", &self.default.as_ref().filter(|_| !secret))
            .field("min", &self.min)
            .field("max", &self.max)
            .field("doc", &self.doc)
            .finish()
    }
}

/// As it was written, without a password that stands in it.
impl fmt::Debug for Template {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let pieces = self.pieces.iter().map(|piece| match piece {
            Piece::Text(text) => text.clone(),
            Piece::Property { name, .. } => format!("${{properties.{name}}}"),
            Piece::Variable { name, .. } => format!("${{{name}}}"),
        });
        let written: String = pieces.collect();
        fmt::Debug::fmt(&mask(&written), f)
    }
}

impl Template {
    /// The text itself where nothing is substituted.
    pub fn literal(&self) -> Option<&str> {
        match self.pieces.as_slice() {
            [] => Some(""),
            [Piece::Text(text)] => Some(text),
            _ => None,
        }
    }
}

/// A whole number that may come from a property.
#[derive(Clone, Debug, PartialEq)]
pub enum Amount {
    /// Written out.
    Number(u64),
    /// From `${properties.x}`.
    Template(Template),
}
