//! Names and types that a composite or an implementation gives, with their place if they have one.

use asmotion_datum::{Schema, Shape};
use asmotion_diagnostics::Span;

/// A name and where it was declared, if that can be shown.
#[derive(Clone, Debug)]
pub struct NamedAt {
    /// As it is written or declared.
    pub text: String,
    /// Its place; `None` where only the implementation declares it.
    pub at: Option<Span>,
}

/// A type or an interface and where it was written, if that can be shown.
#[derive(Clone, Debug)]
pub struct TypeAt {
    /// As it is written or declared.
    pub text: String,
    /// Its place; `None` where only the implementation declares it.
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
    /// A type that a component declares.
    pub(crate) fn declared(schema: &Schema) -> Option<Self> {
        let unknown = schema.shape == Shape::Any && schema.name.is_empty();
        (!unknown).then(|| Self {
            text: schema.to_string(),
            at: None,
        })
    }

    /// A type that was written somewhere; the empty one is no type at all.
    pub(crate) fn new(text: impl Into<String>, at: Option<Span>) -> Option<Self> {
        let text = text.into();
        (!text.is_empty()).then_some(Self { text, at })
    }
}
