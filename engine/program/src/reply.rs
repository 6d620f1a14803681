//! Replies as data: their type, and their parts with the place of an error.

use asmotion_datum::{Datum, Schema};

use crate::error::ProgramError;

/// Checks the type of a reply.
///
/// # Errors
/// The fault, if the reply is one; else the wrong type.
pub(crate) fn expect(
    reply: &Datum,
    wanted: &str,
    request: &'static str,
) -> Result<(), ProgramError> {
    match text_of(reply, "type").as_deref() {
        Some(kind) if kind == wanted => Ok(()),
        Some("fault") => Err(fault(reply)),
        Some(other) => Err(ProgramError::Protocol(format!(
            "the reply to `{request}` is `{other}`, expected `{wanted}`"
        ))),
        None => Err(ProgramError::Protocol(format!(
            "the reply to `{request}` is a map without the text `type`"
        ))),
    }
}

/// Returns whether a reply has this type.
pub(crate) fn is(reply: &Datum, kind: &str) -> bool {
    text_of(reply, "type").as_deref() == Some(kind)
}

/// A fault that the program reports.
pub(crate) fn fault(of: &Datum) -> ProgramError {
    ProgramError::Fault {
        code: text_of(of, "code").unwrap_or_default(),
        text: text_of(of, "text").unwrap_or_default(),
    }
}

/// A text of a record; `None` if it is absent or no text.
pub(crate) fn text_of(record: &Datum, key: &str) -> Option<String> {
    value_of(record, key)?.as_text().map(str::to_owned)
}

/// A value of a record; `None` if it is absent.
pub(crate) fn value_of<'d>(record: &'d Datum, key: &str) -> Option<&'d Datum> {
    let Datum::Record(entries) = record else {
        return None;
    };
    let (_, value) = entries.iter().find(|(name, _)| name == key)?;
    Some(value)
}

/// The elements of a list of a record; none if it is absent.
///
/// # Errors
/// The value is no list.
pub(crate) fn list_of<'d>(record: &'d Datum, key: &str) -> Result<&'d [Datum], ProgramError> {
    match value_of(record, key) {
        None | Some(Datum::Null) => Ok(&[]),
        Some(Datum::List(elements)) => Ok(elements),
        Some(other) => Err(ProgramError::Protocol(format!(
            "`{key}` is {}, expected a list",
            other.kind()
        ))),
    }
}

/// An integer of a record; `None` if it is absent.
///
/// # Errors
/// The value is no integer, or negative.
pub(crate) fn count_of(record: &Datum, key: &str) -> Result<Option<u64>, ProgramError> {
    let Some(value) = value_of(record, key).filter(|it| !it.is_null()) else {
        return Ok(None);
    };
    let number = value.as_int().and_then(|it| u64::try_from(it).ok());
    number
        .map(Some)
        .ok_or_else(|| ProgramError::Protocol(format!("`{key}` is not an integer from 0")))
}

/// An element of a list that is a pair of a name and a value.
///
/// # Errors
/// The element is no such pair.
pub(crate) fn pair<'d>(
    element: &'d Datum,
    list: &str,
) -> Result<(&'d str, &'d Datum), ProgramError> {
    if let Datum::List(parts) = element
        && let [Datum::Text(name), value] = parts.as_slice()
    {
        return Ok((name, value));
    }
    Err(ProgramError::Protocol(format!(
        "an element of `{list}` is not a pair of a name and a value"
    )))
}

/// Data in the form of its type.
///
/// # Errors
/// The data do not fit the type; the error names the place.
pub(crate) fn fitting(schema: &Schema, datum: &Datum, place: &str) -> Result<Datum, ProgramError> {
    let complete = schema.complete(datum.clone());
    complete.map_err(|error| {
        ProgramError::Protocol(format!("{place} does not fit `{schema}`: {error}"))
    })
}
