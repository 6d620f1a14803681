//! The contents of messages, as far as a binding or protocol determines them.

use crate::actor::{ActorInput, Codomain};
use crate::bound::term_of;
use asmotion_coordinator::Argument;
use asmotion_datum::Datum;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// A message that is sent.
#[derive(Debug)]
pub(crate) enum SentMessage<'a> {
    /// Values of functions; the other fields have their initial values if the message is complete, or else those that they have in
    /// all of `contents`.
    Values {
        is_complete: bool,
        values: Vec<SentValue<'a>>,
        key: &'a [(String, String)],
        /// Contents of all messages of this kind, if they are known.
        contents: &'a [Argument],
    },
    /// Content that the composite describes.
    Built(&'a Argument),
    /// Any content: a variable for each field that is read.
    Any(&'a BTreeMap<Option<String>, FieldVariable>),
}

/// The value of a function in a message.
#[derive(Debug)]
pub(crate) struct SentValue<'a> {
    /// Field of the value; `None` if it is the message.
    pub field: Option<&'a str>,
    pub term: &'a str,
    pub codomain: &'a Codomain,
}

/// A variable for a field of a message with any content.
#[derive(Clone, Debug)]
pub(crate) struct FieldVariable {
    pub variable: String,
    /// Domain that it ranges over.
    pub domain: String,
    /// Texts and the literals of the domain that stand for them.
    pub texts: Vec<(String, String)>,
}

/// The value that an input takes from a message.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum TakenValue {
    /// A term, which may be undef if the second is `true`: the message then does not fit.
    Term(String, bool),
    /// Not determined.
    Unknown,
}

/// A part of a message.
enum Part<'a> {
    Term(&'a str, &'a Codomain),
    Constant(Cow<'a, Datum>),
    Initial,
    Variable(&'a FieldVariable),
    Unknown,
}

impl SentMessage<'_> {
    /// Returns the value that an input takes.
    pub fn value(&self, input: &ActorInput) -> TakenValue {
        let part = self.part(input.field.as_deref());
        if !input.is.is_empty() {
            return is_one_of(&part, &input.is);
        }
        if input.codomain.is_boolean() {
            return truth(&part);
        }
        element(&part, &input.codomain)
    }

    /// Returns `Some(false)` if the key of the message selects another location, `None` if that is not known.
    pub fn selects(&self, input: &ActorInput) -> Option<bool> {
        let mut known = Some(true);
        for (field, element) in &input.key {
            let selected = match self.part(Some(field)) {
                Part::Constant(datum) => Some(match &*datum {
                    Datum::Text(text) => text == element,
                    Datum::Int(number) => number.to_string() == *element,
                    Datum::Bool(truth) => truth.to_string() == *element,
                    Datum::Null
                    | Datum::Float(_)
                    | Datum::Bytes(_)
                    | Datum::Numbers(_)
                    | Datum::List(_)
                    | Datum::Record(_) => false,
                }),
                Part::Initial => Some(false),
                Part::Term(..) | Part::Variable(_) | Part::Unknown => None,
            };
            match selected {
                Some(false) => return Some(false),
                Some(true) => {}
                None => known = None,
            }
        }
        known
    }

    fn part(&self, path: Option<&str>) -> Part<'_> {
        match self {
            Self::Values {
                is_complete,
                values,
                key,
                contents,
            } => {
                let keyed = key.iter().find(|(field, _)| Some(field.as_str()) == path);
                if let Some((_, element)) = keyed {
                    return Part::Constant(Cow::Owned(Datum::text(element.clone())));
                }
                // a message with one field is written and read with and without the name of the field
                let sent = match values.as_slice() {
                    [only] if only.field.is_none() || path.is_none() => Some(only),
                    all => all.iter().find(|it| it.field == path),
                };
                match sent {
                    Some(sent) => Part::Term(sent.term, sent.codomain),
                    None if *is_complete && path.is_some() => Part::Initial,
                    None if *is_complete => Part::Unknown,
                    None => common(contents, path),
                }
            }
            Self::Built(argument) => built(argument, path),
            Self::Any(fields) => {
                let variable = fields.get(&path.map(str::to_owned));
                variable.map_or(Part::Unknown, Part::Variable)
            }
        }
    }
}

/// The part that all messages have in common.
fn common<'a>(contents: &'a [Argument], path: Option<&str>) -> Part<'a> {
    let mut parts = contents.iter().map(|it| built(it, path));
    match parts.next() {
        Some(Part::Constant(first)) => {
            let is_same = |part: Part<'_>| matches!(part, Part::Constant(it) if it == first);
            if parts.all(is_same) {
                Part::Constant(first)
            } else {
                Part::Unknown
            }
        }
        Some(Part::Initial) if parts.all(|part| matches!(part, Part::Initial)) => Part::Initial,
        Some(Part::Initial | Part::Term(..) | Part::Variable(_) | Part::Unknown) | None => {
            Part::Unknown
        }
    }
}

fn built<'a>(argument: &'a Argument, path: Option<&str>) -> Part<'a> {
    match argument {
        Argument::Kept { .. } | Argument::Term(_) => Part::Unknown,
        Argument::Value(constant) => match path {
            Some(path) => constant
                .datum
                .get(path)
                .map_or(Part::Initial, Part::Constant),
            None => Part::Constant(Cow::Borrowed(&constant.datum)),
        },
        Argument::Record(fields) => {
            let Some(path) = path else {
                return match fields.as_slice() {
                    [(_, only)] => built(only, None),
                    _ => Part::Unknown,
                };
            };
            let (first, rest) = match path.split_once('.') {
                Some((first, rest)) => (first, Some(rest)),
                None => (path, None),
            };
            let field = fields.iter().find(|(name, _)| name == first);
            field.map_or(Part::Initial, |(_, value)| built(value, rest))
        }
    }
}

fn term(text: impl Into<String>) -> TakenValue {
    TakenValue::Term(text.into(), false)
}

fn any_of(subject: &str, literals: &[&str]) -> TakenValue {
    if literals.is_empty() {
        return term("false");
    }
    let equal = literals.iter().map(|it| format!("{subject} = {it}"));
    term(format!("({})", equal.collect::<Vec<_>>().join(" or ")))
}

/// Whether a text is one of several.
fn is_one_of(part: &Part<'_>, texts: &[String]) -> TakenValue {
    let is_listed = |text: &str| texts.iter().any(|it| it.eq_ignore_ascii_case(text));
    match part {
        Part::Term(subject, codomain) => match &codomain.elements {
            Some(elements) => {
                let listed = elements.iter().filter(|it| is_listed(&it.declared));
                let listed: Vec<&str> = listed.map(|it| it.name.as_str()).collect();
                any_of(subject, &listed)
            }
            None => TakenValue::Unknown,
        },
        Part::Constant(datum) => term(datum.as_text().is_some_and(is_listed).to_string()),
        Part::Initial => term(is_listed("").to_string()),
        Part::Variable(field) => {
            let listed = field.texts.iter().filter(|(text, _)| is_listed(text));
            let listed: Vec<&str> = listed.map(|(_, literal)| literal.as_str()).collect();
            any_of(&field.variable, &listed)
        }
        Part::Unknown => TakenValue::Unknown,
    }
}

/// A truth value; of a list, whether it has elements.
fn truth(part: &Part<'_>) -> TakenValue {
    match part {
        Part::Term(subject, codomain) if codomain.is_boolean() => term(*subject),
        Part::Term(..) | Part::Unknown => TakenValue::Unknown,
        Part::Constant(datum) => match (datum.as_bool(), datum.count()) {
            (Some(truth), _) => term(truth.to_string()),
            (None, Some(count)) => term((count > 0).to_string()),
            (None, None) => TakenValue::Unknown,
        },
        Part::Initial => term("false"),
        Part::Variable(field) => term(field.variable.clone()),
    }
}

/// An element of a domain.
fn element(part: &Part<'_>, codomain: &Codomain) -> TakenValue {
    match part {
        Part::Term(subject, from) => match (&from.elements, &codomain.elements) {
            (Some(_), Some(to)) if from.text == codomain.text && !to.is_empty() => term(*subject),
            (Some(elements), Some(_)) => {
                let mut fits = true;
                let cases = elements.iter().filter_map(|it| {
                    let to = codomain.named(&it.declared);
                    fits &= to.is_some();
                    Some(format!("case {}: {}", it.name, to?.name))
                });
                let cases: Vec<String> = cases.collect();
                if cases.is_empty() {
                    return TakenValue::Term("undef".to_owned(), true);
                }
                let text = format!(
                    "switch {subject} {} otherwise undef endswitch",
                    cases.join(" ")
                );
                TakenValue::Term(text, !fits)
            }
            (None, None) if from.text == codomain.text => term(*subject),
            (_, _) => TakenValue::Unknown,
        },
        Part::Constant(datum) => match term_of(datum, codomain) {
            Some(text) => term(text),
            None => TakenValue::Term("undef".to_owned(), true),
        },
        Part::Initial if codomain.elements.is_some() => TakenValue::Term("undef".to_owned(), true),
        Part::Initial | Part::Unknown => TakenValue::Unknown,
        Part::Variable(field) => match field.texts.as_slice() {
            [] => term(field.variable.clone()),
            texts => {
                let cases = texts.iter().filter_map(|(text, literal)| {
                    Some(format!("case {literal}: {}", codomain.named(text)?.name))
                });
                let cases: Vec<String> = cases.collect();
                let subject = &field.variable;
                let text = format!(
                    "switch {subject} {} otherwise undef endswitch",
                    cases.join(" ")
                );
                TakenValue::Term(text, true)
            }
        },
    }
}
