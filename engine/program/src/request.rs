//! Requests as data.

use asmotion_datum::{Datum, FieldName};

/// A request in the making: a record with the key `type`.
pub(crate) struct ProgramRequest(Vec<(FieldName, Datum)>);

impl ProgramRequest {
    /// A request of this type.
    pub(crate) fn of(kind: &'static str) -> Self {
        Self(Vec::new()).put("type", kind)
    }

    /// Adds a key.
    pub(crate) fn put(mut self, key: &'static str, value: impl Into<Datum>) -> Self {
        self.0.push((key.into(), value.into()));
        self
    }

    /// Adds a record or a list, unless it is empty.
    pub(crate) fn put_some(self, key: &'static str, value: Datum) -> Self {
        if value.count() == Some(0) {
            return self;
        }
        self.put(key, value)
    }

    /// The request as data.
    pub(crate) fn datum(self) -> Datum {
        Datum::Record(self.0)
    }
}
