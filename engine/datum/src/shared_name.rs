//! Field names that all data of a process share.

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

use crate::value::FieldName;

/// Number of names that are shared. The definitions of ROS have about a thousand; those of a stranger must not fill the memory, which
/// shared names occupy until the process ends.
const MOST_NAMES: usize = 1 << 16;
/// Bytes of the longest name that is shared.
const LONGEST: usize = 128;

/// Returns a field name that is cloned without an allocation, for the schemas of a definition that is read while the program runs. Every
/// message that is decoded with such a schema has a clone of each of its names.
///
/// A name that is very long, or comes after very many others, is a text of its own.
///
/// ```
/// use asmotion_datum::{FieldName, shared_name};
///
/// let name = String::from("linear");
/// assert!(matches!(shared_name(&name), FieldName::Borrowed("linear")));
/// ```
pub fn shared_name(name: &str) -> FieldName {
    static NAMES: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
    let mut names = NAMES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = names.get(name) {
        return FieldName::Borrowed(known);
    }
    if names.len() >= MOST_NAMES || name.len() > LONGEST {
        return FieldName::Owned(name.to_owned());
    }
    let name: &'static str = Box::leak(Box::from(name));
    names.insert(name);
    FieldName::Borrowed(name)
}
