//! Checks messages from outside against the type of the input that is to read them.

use asmotion_datum::{Datum, Schema};
use asmotion_runtime::RunError;

/// Checks a message against the declared type of an input, `Component.port`. The port of a specification itself takes every
/// message, and the specification would only count it as unsuitable.
///
/// # Errors
/// [`RunError::Mismatch`] with the first difference.
pub fn check_message(message: &Datum, input: &str, schema: &Schema) -> Result<(), RunError> {
    schema
        .accepts(message)
        .map_err(|source| RunError::Mismatch {
            target: input.to_owned(),
            expected: schema.to_string(),
            source: Box::new(source),
        })
}
