//! What can be wrong with a composite file before its meaning is looked at.

use asmotion_diagnostics::{Diagnostic, Span};

use crate::finding::Finding;
use crate::nearest::{Nearest, Suggest};

#[derive(Debug, thiserror::Error)]
pub(crate) enum ReadError {
    #[error("this is not TOML: {message}")]
    Syntax {
        message: String,
        at: Span,
        earlier: Option<Span>,
    },
    #[error("`{path}` cannot be read: {reason}")]
    Unreadable {
        path: String,
        reason: String,
        at: Option<Span>,
    },
    #[error("{of} has no key `{key}`")]
    UnknownKey {
        key: String,
        of: &'static str,
        at: Span,
        known: Vec<&'static str>,
        nearest: Option<Nearest>,
    },
    #[error("{of} needs the key `{key}`")]
    MissingKey {
        key: &'static str,
        of: &'static str,
        at: Span,
        example: String,
    },
    #[error("`{key}` takes {expected}, not {found}")]
    WrongType {
        key: String,
        expected: &'static str,
        found: &'static str,
        at: Span,
        example: String,
    },
    #[error("`{key}` cannot be `{word}`")]
    UnknownWord {
        key: String,
        word: String,
        at: Span,
        known: Vec<&'static str>,
        nearest: Option<Nearest>,
    },
    #[error("`{key}` is {value}, but must lie between {least} and {greatest}")]
    OutOfRange {
        key: String,
        value: String,
        least: String,
        greatest: String,
        at: Span,
    },
    #[error("this file says it is `{found}`, which this version does not read")]
    UnknownSchema {
        found: String,
        wanted: &'static str,
        at: Span,
    },
    #[error("`{text}` cannot be {what}")]
    NotAName {
        text: String,
        what: &'static str,
        rule: &'static str,
        at: Span,
    },
    #[error("`{second}` cannot stand beside `{first}`")]
    Excluded {
        first: String,
        first_at: Span,
        second: String,
        at: Span,
        reason: &'static str,
    },
    #[error("nothing is substituted in `{key}`")]
    NoSubstitution { key: String, at: Span },
    #[error("this substitution cannot be read: {reason}")]
    BadSubstitution { reason: &'static str, at: Span },
}

impl Finding for ReadError {
    fn diagnostic(&self) -> Diagnostic {
        match self {
            Self::Syntax { at, earlier, .. } => {
                let diagnostic = Diagnostic::error("C001", self).label(*at, "found here");
                match earlier {
                    Some(earlier) => diagnostic
                        .label(*earlier, "it already stands here")
                        .help("give the second one another name, or merge the two"),
                    None => diagnostic,
                }
            }
            Self::Unreadable { at, .. } => {
                let diagnostic = Diagnostic::error("C002", self);
                match at {
                    Some(at) => diagnostic
                        .label(*at, "named here")
                        .help("write its path, from the folder of this file"),
                    None => diagnostic.help("check the path"),
                }
            }
            Self::UnknownKey {
                at, known, nearest, ..
            } => {
                let keys = format!("the keys are {}", enumerate(known));
                Diagnostic::error("C003", self)
                    .label(*at, "unknown key")
                    .suggest_or(*at, nearest, keys)
            }
            Self::MissingKey {
                key, at, example, ..
            } => Diagnostic::error("C004", self)
                .label(*at, format!("`{key}` is missing here"))
                .help(format!("for example `{key} = {example}`")),
            Self::WrongType {
                key,
                expected,
                at,
                example,
                ..
            } => Diagnostic::error("C005", self)
                .label(*at, format!("expected {expected}"))
                .help(format!("write it as in `{key} = {example}`")),
            Self::UnknownWord {
                at, known, nearest, ..
            } => Diagnostic::error("C006", self)
                .label(*at, "unknown word")
                .help(format!("it can be {}", enumerate(known)))
                .suggest(*at, nearest),
            Self::OutOfRange {
                least,
                greatest,
                at,
                ..
            } => Diagnostic::error("C007", self)
                .label(*at, "out of range")
                .help(format!("take a number from {least} to {greatest}")),
            Self::UnknownSchema { wanted, at, .. } => Diagnostic::error("C008", self)
                .label(*at, "not known here")
                .guess(format!("this version reads `{wanted}`"), *at, *wanted),
            Self::NotAName { rule, at, .. } => Diagnostic::error("C009", self)
                .label(*at, "not of this form")
                .help(*rule),
            Self::Excluded {
                first,
                first_at,
                at,
                reason,
                ..
            } => Diagnostic::error("C010", self)
                .label(*at, *reason)
                .label(*first_at, format!("`{first}` stands here")),
            Self::NoSubstitution { at, .. } => Diagnostic::error("C011", self)
                .label(*at, "this would be taken as it stands")
                .help("substitution works in values of properties, in times and in endpoints"),
            Self::BadSubstitution { at, .. } => Diagnostic::error("C012", self)
                .label(*at, "begins here")
                .help(
                    "write `${properties.name}`, `${VARIABLE}` or `${VARIABLE:-default}`; \
                     `$$` is a dollar sign",
                ),
        }
    }
}

/// The names in backquotes with commas and a final "or".
pub(crate) fn enumerate(names: &[&str]) -> String {
    joined(names, "or")
}

/// "it has `a`, `b` and `c`": what there is instead of what was not found.
pub(crate) fn has<'n>(what: &str, names: impl IntoIterator<Item = &'n str>) -> String {
    let names: Vec<&str> = names.into_iter().collect();
    match names.is_empty() {
        true => format!("it has no {what}"),
        false => format!("it has {}", joined(&names, "and")),
    }
}

fn joined(names: &[&str], last_word: &str) -> String {
    match names {
        [] => "none".to_owned(),
        [only] => format!("`{only}`"),
        [first @ .., last] => {
            let first: Vec<String> = first.iter().map(|name| format!("`{name}`")).collect();
            format!("{} {last_word} `{last}`", first.join(", "))
        }
    }
}
