//! Values of out locations in messages.

use crate::binding::PublishWhen;
use asmotion_component::Out;
use asmotion_datum::{Datum, FieldName};

/// The way in which the value of an out location is published.
pub(crate) struct PublishedValue {
    pub port: Out<Datum>,
    /// Field of the value; `None` if it is the message.
    pub field: Option<String>,
    /// Fields that say which location the message is about, and their values.
    pub key: Vec<(String, Datum)>,
    pub when: PublishWhen,
}

impl PublishedValue {
    /// Returns whether another value is a field of the same message.
    fn shares_message(&self, other: &Self) -> bool {
        self.field.is_some()
            && other.field.is_some()
            && self.port == other.port
            && self.key == other.key
    }
}

/// For each output, the outputs whose values are in its message, by position; none if the message is that of an earlier output.
/// An output that publishes no value is alone.
///
/// Fields of one message that are bound to several locations are sent together: a message of one of them would have the defaults of the
/// others, which a reader takes for values.
pub(crate) fn messages(outputs: &[Option<&PublishedValue>]) -> Vec<Vec<usize>> {
    let members = |at: usize, value: &PublishedValue| {
        let all = outputs.iter().enumerate();
        let same = all.filter(|(_, it)| it.is_some_and(|it| value.shares_message(it)));
        let same: Vec<(usize, Option<&str>)> = same
            .filter_map(|(at, it)| Some((at, it.as_ref()?.field.as_deref())))
            .collect();
        let mut fields: Vec<Option<&str>> = same.iter().map(|(_, field)| *field).collect();
        fields.sort_unstable();
        fields.dedup();
        // several values for one field are several messages
        if same.is_empty() || fields.len() < same.len() {
            return vec![at];
        }
        same.into_iter().map(|(at, _)| at).collect()
    };
    let all = outputs.iter().enumerate().map(|(at, value)| {
        let members = value.map_or_else(|| vec![at], |value| members(at, value));
        let is_first = members.first() == Some(&at);
        if is_first { members } else { Vec::new() }
    });
    all.collect()
}

/// The message with values in fields, or with one value as a whole, and with the fields of a key.
pub(crate) fn message_of<'f>(
    values: impl Iterator<Item = (Option<&'f str>, Datum)>,
    key: &[(String, Datum)],
) -> Datum {
    // enough for one value, which is what most messages have: without it, there would be memory for four, in queues of many messages
    let mut fields = Vec::with_capacity(key.len() + 1);
    for (path, element) in key {
        insert(&mut fields, path, element.clone());
    }
    for (field, value) in values {
        match field {
            Some(field) => insert(&mut fields, field, value),
            None if key.is_empty() => return value,
            None => {}
        }
    }
    Datum::Record(fields)
}

/// Inserts a value at a path of names, creating the records on the way.
fn insert(fields: &mut Vec<(FieldName, Datum)>, path: &str, value: Datum) {
    let Some((name, rest)) = path.split_once('.') else {
        fields.push((path.to_owned().into(), value));
        return;
    };
    let known = fields.iter_mut().find(|(known, _)| known == name);
    if let Some((_, Datum::Record(inner))) = known {
        insert(inner, rest, value);
        return;
    }
    let mut inner = Vec::new();
    insert(&mut inner, rest, value);
    fields.push((name.to_owned().into(), Datum::Record(inner)));
}
