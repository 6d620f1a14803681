//! Text form of values, in the notation of AsmetaL literals.

use crate::value::{Atom, RuleId, Value};
use std::fmt::{self, Write};

/// The names of the atoms and rules of a machine.
pub trait ValueNames {
    /// Writes the name of an atom, as in `IDLE` or `order!3`.
    ///
    /// # Errors
    /// Errors of the formatter only.
    fn atom(&self, atom: Atom, to: &mut fmt::Formatter<'_>) -> fmt::Result;

    /// Writes the name of a rule, as in `r_work`.
    ///
    /// # Errors
    /// Errors of the formatter only.
    fn rule(&self, rule: RuleId, to: &mut fmt::Formatter<'_>) -> fmt::Result;
}

/// A value with the names needed to display it.
pub struct DisplayValue<'a> {
    value: &'a Value,
    names: &'a dyn ValueNames,
}

/// Returns the name of an element that `extend` added to a domain, as in `person!1`: the domain's
/// name with a lower-case initial, and a number.
pub fn element_name(domain: &str, number: impl fmt::Display) -> String {
    let mut letters = domain.chars();
    let first: String = letters
        .next()
        .into_iter()
        .flat_map(char::to_lowercase)
        .collect();
    format!("{first}{}!{number}", letters.as_str())
}

impl Value {
    /// Returns an adapter that displays this value. Reals are written so that reading them returns
    /// the same number, strings and characters are quoted as in JSON, and sets, bags and maps are
    /// in ascending order.
    pub fn show<'a>(&'a self, names: &'a dyn ValueNames) -> DisplayValue<'a> {
        DisplayValue { value: self, names }
    }
}

impl fmt::Display for DisplayValue<'_> {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let show = |value| DisplayValue {
            value,
            names: self.names,
        };
        match self.value {
            Value::Undef => to.write_str("undef"),
            Value::Bool(truth) => write!(to, "{truth}"),
            Value::Int(number) => write!(to, "{number}"),
            Value::Real(number) => write!(to, "{:?}", number.get()),
            Value::Char(character) => quoted(to, '\'', std::iter::once(*character)),
            Value::Atom(atom) => self.names.atom(*atom, to),
            Value::Rule(rule) => self.names.rule(*rule, to),
            Value::Text(text) => quoted(to, '"', text.chars()),
            Value::Complex(number) => {
                let (re, im) = (number.0.get(), number.1.get());
                let sign = if im.is_sign_negative() { '-' } else { '+' };
                write!(to, "{re:?}{sign}i{:?}", im.abs())
            }
            Value::Tuple(items) => list(to, "(", items.iter().map(show), ")"),
            Value::Seq(items) => list(to, "[", items.iter().map(show), "]"),
            Value::Set(items) => list(to, "{", items.iter().map(show), "}"),
            Value::Bag(items) => {
                let each = items
                    .iter()
                    .flat_map(|(item, &count)| std::iter::repeat_n(item, count));
                list(to, "<", each.map(show), ">")
            }
            // `{}` denotes the empty set
            Value::Map(pairs) if pairs.is_empty() => to.write_str("{->}"),
            Value::Map(pairs) => {
                let pairs = pairs
                    .iter()
                    .map(|(key, value)| DisplayEntry(show(key), show(value)));
                list(to, "{", pairs, "}")
            }
        }
    }
}

/// An entry of a map: `key -> value`.
struct DisplayEntry<'a>(DisplayValue<'a>, DisplayValue<'a>);

impl fmt::Display for DisplayEntry<'_> {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "{} -> {}", self.0, self.1)
    }
}

fn list(
    to: &mut fmt::Formatter<'_>,
    open: &str,
    items: impl Iterator<Item = impl fmt::Display>,
    close: &str,
) -> fmt::Result {
    to.write_str(open)?;
    for (index, item) in items.enumerate() {
        if index > 0 {
            to.write_str(", ")?;
        }
        write!(to, "{item}")?;
    }
    to.write_str(close)
}

/// Writes quoted characters, escaping the quote, the backslash and control characters.
fn quoted(
    to: &mut fmt::Formatter<'_>,
    quote: char,
    characters: impl Iterator<Item = char>,
) -> fmt::Result {
    to.write_char(quote)?;
    for character in characters {
        match character {
            '\n' => to.write_str("\\n")?,
            '\r' => to.write_str("\\r")?,
            '\t' => to.write_str("\\t")?,
            '\\' => to.write_str("\\\\")?,
            // all control characters are below U+10000, so four digits suffice
            control if control.is_control() => write!(to, "\\u{:04x}", u32::from(control))?,
            plain => {
                if plain == quote {
                    to.write_char('\\')?;
                }
                to.write_char(plain)?;
            }
        }
    }
    to.write_char(quote)
}
