//! Names and types with the optional source location of their declaration.

use asmotion_datum::{Schema, Shape};
use asmotion_diagnostics::Span;

/// A name and the location of its declaration, if in a source file.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedAt {
    /// Name as written or declared.
    pub text: String,
    /// Source location; `None` if only the implementation declares it.
    pub at: Option<Span>,
}

/// A message type or interface and its source location, if in a source file.
#[derive(Clone, Debug, PartialEq)]
pub struct TypeAt {
    /// Type name as written or declared.
    pub text: String,
    /// Source location; `None` if only the implementation declares it.
    pub at: Option<Span>,
}

impl NamedAt {
    pub(crate) fn new(text: impl Into<String>, at: Option<Span>) -> Self {
        Self {
            text: text.into(),
            at,
        }
    }
}

impl TypeAt {
    /// Creates a type from a declared schema; `None` if the schema is unspecified.
    pub(crate) fn declared(schema: &Schema) -> Option<Self> {
        let unknown = schema.shape == Shape::Any && schema.name.is_empty();
        (!unknown).then(|| Self {
            text: schema.to_string(),
            at: None,
        })
    }

    /// Creates a type from its written name; `None` if the name is empty.
    pub(crate) fn new(text: impl Into<String>, at: Option<Span>) -> Option<Self> {
        let text = text.into();
        (!text.is_empty()).then_some(Self { text, at })
    }
}
