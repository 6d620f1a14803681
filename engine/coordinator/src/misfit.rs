//! Describes messages and requests that do not fit a specification: each cause once, and only the first few of an input.

use asmotion_datum::Datum;
use asmotion_lang::ir::{DomainId, Program, ValueShape};
use serde::{Deserialize, Serialize};

/// Most causes of an input that are reported: messages come from outside.
const MAX_CAUSES: usize = 8;
/// Most characters of a value that are shown.
const MAX_SHOWN: usize = 160;

/// The causes that have been reported.
#[derive(Clone, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub(crate) struct MisfitCauses(Vec<String>);

impl MisfitCauses {
    /// Returns a cause that has not been reported. It is not even formulated once there have been enough.
    pub fn new_cause(&mut self, cause: impl FnOnce() -> String) -> Option<String> {
        if self.0.len() >= MAX_CAUSES {
            return None;
        }
        let cause = cause();
        if self.0.contains(&cause) {
            return None;
        }
        self.0.push(cause.clone());
        Some(cause)
    }
}

/// The text of a value of a message, which may be long.
pub(crate) fn shown(value: &Datum) -> String {
    let text = value.to_string();
    match text.char_indices().nth(MAX_SHOWN) {
        Some((end, _)) => format!("{} …", text.get(..end).unwrap_or_default()),
        None => text,
    }
}

/// The domain of the values of a shape, as the language writes it.
pub(crate) fn domain_text(shape: &ValueShape, program: &Program) -> String {
    shape.domain_text(&|DomainId(domain)| {
        let name = program.symbols.domains.get(domain as usize);
        name.map_or_else(String::new, ToString::to_string)
    })
}
