//! Building blocks of messages: enumerations and locations.

use crate::signature::FunctionInfo;
use asmotion_diagnostics::{Diagnostic, Span};

/// Joins the names in backquotes with commas and "or".
pub(crate) fn enumerate(names: &[&str]) -> String {
    joined(names, "or")
}

/// Returns the locations of a function that are missing, at most four of them; the function itself if none are listed.
pub(crate) fn missing(function: &FunctionInfo, locations: &[String]) -> String {
    let shown: Vec<&str> = locations.iter().take(4).map(String::as_str).collect();
    match (shown.as_slice(), locations.len() - shown.len()) {
        ([], _) => format!("`{}`", function.name),
        (shown, 0) => enumerate(shown),
        (shown, more) => format!("{} and {more} others", joined(shown, "and")),
    }
}

/// Returns a note listing the existing names, such as "it has `a`, `b` and `c`".
pub(crate) fn has<'n>(what: &str, names: impl IntoIterator<Item = &'n str>) -> String {
    let names: Vec<&str> = names.into_iter().collect();
    if names.is_empty() {
        format!("it has no {what}")
    } else {
        format!("it has {}", joined(&names, "and"))
    }
}

/// Joins the names in backquotes with commas and the last word.
pub(crate) fn joined(names: &[&str], last_word: &str) -> String {
    match names {
        [] => "none".to_owned(),
        [only] => format!("`{only}`"),
        [first @ .., last] => {
            let first: Vec<String> = first.iter().map(|name| format!("`{name}`")).collect();
            format!("{} {last_word} `{last}`", first.join(", "))
        }
    }
}

/// Note of diagnostics about values set outside the files.
const OUTSIDE: &str = "set from outside the file";

/// Returns `true` if [`label_or_outside`] found no place in a file for the value.
pub(crate) fn is_outside(diagnostic: &Diagnostic) -> bool {
    diagnostic.notes.iter().any(|note| note == OUTSIDE)
}

/// Labels the place of a value, or notes that it was set from outside the file.
pub(crate) fn label_or_outside(diagnostic: Diagnostic, at: Option<Span>, text: &str) -> Diagnostic {
    match at {
        Some(at) => diagnostic.label(at, text),
        None => diagnostic.note(OUTSIDE),
    }
}
