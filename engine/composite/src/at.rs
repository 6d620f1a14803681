//! Values with their location in the source file.

use std::ops::Deref;

use asmotion_diagnostics::Span;

/// A value and its source location; dereferences to the value.
#[derive(Clone, Debug, PartialEq)]
pub struct At<T> {
    /// The parsed value.
    pub value: T,
    /// Source location of the value; for a quoted string, the characters between the quotes.
    pub span: Span,
}

impl<T> At<T> {
    /// Creates a value located at `span`.
    pub fn new(value: T, span: Span) -> Self {
        Self { value, span }
    }

    /// Maps the value and keeps the location.
    pub fn map<U>(self, change: impl FnOnce(T) -> U) -> At<U> {
        At::new(change(self.value), self.span)
    }
}

impl<T> Deref for At<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}
