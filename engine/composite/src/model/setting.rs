//! Externally set values: properties, substitutions and amounts.

use asmotion_derive::{Table, Word};
use std::fmt;

use crate::at::At;
use crate::table::NamedValue;
use crate::template::Template;
use crate::tree::Node;

/// A property of the composite, set by the integrator.
#[derive(Clone, Table)]
#[table(
    of = "a property",
    example = "{ type = \"f64\", default = 0.35, min = 0.0, max = 1.0 }"
)]
pub struct Property {
    /// Name of the property.
    #[key(entry = thing)]
    pub name: At<String>,
    /// Type of the value.
    #[key(name = "type", example = "\"f64\"")]
    pub kind: At<PropertyType>,
    /// Default value; a property without one must be set.
    pub default: Option<Node>,
    /// Minimum value.
    pub min: Option<At<f64>>,
    /// Maximum value.
    pub max: Option<At<f64>>,
    /// Description.
    #[key(example = "\"Safety distance around obstacles\"")]
    pub doc: Option<At<String>>,
}

/// Type of a property: a scalar or a list of scalars (`f64[]`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PropertyType {
    /// Type of the scalar or of the list elements.
    pub scalar: Scalar,
    /// Whether the value is a list.
    pub list: bool,
}

/// Type of a single value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum Scalar {
    /// String.
    #[default]
    #[word("string")]
    Text,
    /// Boolean.
    #[word("bool")]
    Boolean,
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
    /// 64-bit unsigned integer, limited to 63 bits by TOML.
    U64,
    /// Single-precision floating-point number.
    F32,
    /// Double-precision floating-point number.
    F64,
    /// URI, such as `http://…` or `file:…`.
    Uri,
    /// Path of a file or directory.
    Path,
    /// String that is never displayed.
    Secret,
}

/// An assignment to a property of a component or nested composite.
pub type Setting = NamedValue<Node>;

/// Masks the default value of secrets.
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

/// An integer, possibly taken from a property.
#[derive(Clone, Debug, PartialEq)]
pub enum Amount {
    /// A literal number.
    Number(u64),
    /// A substitution such as `${properties.x}`.
    Template(Template),
}
