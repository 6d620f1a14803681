//! Input ports, whose messages are completed by their type.

use std::borrow::Cow;
use std::sync::Arc;

use asmotion_component::In;
use asmotion_datum::{Datum, DatumError, Schema};

/// An input port of the component and the type of its messages.
#[derive(Clone)]
pub(crate) struct TypedInput {
    pub name: String,
    pub port: In<Datum>,
    /// Shared by the coordinators of a specification.
    pub schema: Arc<Schema>,
}

impl TypedInput {
    /// The message with the initial values of the fields that its writer omits, and with floats in place of their texts in JSON,
    /// as typed readers see it. Without this, a location bound to an omitted field would keep the value of an earlier message.
    ///
    /// A message that does not fit the type is returned as it is.
    pub fn completed<'message>(&self, message: &'message Datum) -> Cow<'message, Datum> {
        if self.schema.is_complete(message) {
            return Cow::Borrowed(message);
        }
        let complete = self.schema.complete(message.clone());
        complete.map_or(Cow::Borrowed(message), Cow::Owned)
    }

    /// As [`completed`](Self::completed), for a message that has to fit the type: unknown fields are errors, as for other readers.
    pub fn fitting<'message>(
        &self,
        message: &'message Datum,
    ) -> Result<Cow<'message, Datum>, DatumError> {
        self.schema.accepts(message)?;
        Ok(self.completed(message))
    }
}
