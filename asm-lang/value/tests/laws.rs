//! Laws of values: a total order that agrees with equality and hash, and text that reads back.

use asmotion_value::{Atom, Real, RuleId, Value, ValueNames};
use proptest::prelude::*;
use std::collections::hash_map::DefaultHasher;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::hash::{Hash, Hasher};
use std::sync::Arc;

#[test]
fn a_value_is_two_words() {
    assert_eq!(size_of::<Value>(), 16);
    assert!(Value::default().is_undef());
    assert!(!Value::seq([]).is_undef());
}

#[test]
fn reals_are_ordered_totally() {
    let ascending = [
        f64::NEG_INFINITY,
        -1.0,
        -f64::MIN_POSITIVE,
        -0.0,
        0.0,
        1.0,
        f64::INFINITY,
        f64::NAN,
    ]
    .map(Real::new);
    for (index, left) in ascending.iter().enumerate() {
        for (other, right) in ascending.iter().enumerate() {
            assert_eq!(left.cmp(right), index.cmp(&other), "{left:?} and {right:?}");
        }
    }
}

#[test]
fn there_is_one_nan() {
    let others = [
        -f64::NAN,
        f64::from_bits(0x7ff8_0000_0000_0001),
        f64::INFINITY - f64::INFINITY,
    ];
    for nan in others {
        assert_eq!(Real::new(nan), Real::new(f64::NAN));
        assert_eq!(Value::real(nan), Value::real(f64::NAN));
    }
}

#[test]
fn collections_forget_what_they_should() {
    let ints = |numbers: &[i64]| numbers.iter().copied().map(Value::Int).collect::<Vec<_>>();
    assert_eq!(Value::set(ints(&[1, 2, 1])), Value::set(ints(&[2, 1])));
    assert_eq!(Value::bag(ints(&[1, 2, 1])), Value::bag(ints(&[2, 1, 1])));
    assert_ne!(Value::bag(ints(&[1, 2, 1])), Value::bag(ints(&[2, 1])));
    assert_ne!(Value::seq(ints(&[1, 2])), Value::seq(ints(&[2, 1])));
    assert_ne!(Value::seq(ints(&[1, 2])), Value::tuple(ints(&[1, 2])));
    let pairs = [(1, 1), (1, 2)].map(|(key, value)| (Value::Int(key), Value::Int(value)));
    assert_eq!(
        Value::map(pairs.clone()),
        Value::map(pairs.into_iter().skip(1))
    );
}

#[test]
fn values_show_in_the_notation_of_literals() {
    let complex = |re, im| Value::Complex(Arc::new((Real::new(re), Real::new(im))));
    for (value, shown) in [
        (Value::Undef, "undef"),
        (Value::Bool(true), "true"),
        (Value::Int(-3), "-3"),
        (Value::real(3.0), "3.0"),
        (Value::real(-0.0), "-0.0"),
        (Value::real(0.1 + 0.2), "0.30000000000000004"),
        (Value::real(1e21), "1e21"),
        (complex(1.5, -2.0), "1.5-i2.0"),
        (complex(0.0, f64::NAN), "0.0+iNaN"),
        (Value::Char('\''), r"'\''"),
        (Value::Char('"'), "'\"'"),
        (Value::Atom(Atom(7)), "a7"),
        (Value::Rule(RuleId(7)), "r_7"),
        (
            Value::text("say \"ä\"\n\\ it's\u{1}"),
            r#""say \"ä\"\n\\ it's\u0001""#,
        ),
        (Value::tuple([Value::Int(1), Value::text("")]), r#"(1, "")"#),
        (Value::seq([]), "[]"),
        (Value::set([]), "{}"),
        (Value::set([2, 1].map(Value::Int)), "{1, 2}"),
        (Value::bag([2, 1, 2].map(Value::Int)), "<1, 2, 2>"),
        (Value::map([]), "{->}"),
        (Value::map([(Value::Int(1), Value::Undef)]), "{1 -> undef}"),
    ] {
        assert_eq!(value.show(&Numbered).to_string(), shown);
        assert_eq!(read(shown), Some(value));
    }
}

proptest! {
    #[test]
    fn order_equality_and_hash_agree(a in values(), b in values(), c in values()) {
        prop_assert_eq!(&a, &a.clone());
        prop_assert_eq!(a == b, a.cmp(&b).is_eq());
        prop_assert_eq!(a.cmp(&b), b.cmp(&a).reverse());
        prop_assert_eq!(Some(a.cmp(&b)), a.partial_cmp(&b));
        prop_assert!(a != b || hash(&a) == hash(&b));
        if a <= b && b <= c {
            prop_assert!(a <= c);
        }
        // the same contents, constructed in another order, are the same value
        prop_assert_eq!(Value::set([a.clone(), b.clone()]), Value::set([b.clone(), a.clone()]));
        prop_assert_eq!(hash(&Value::bag([a.clone(), b.clone()])), hash(&Value::bag([b, a])));
    }

    #[test]
    fn a_shown_value_reads_back(value in values()) {
        let shown = value.show(&Numbered).to_string();
        prop_assert_eq!(read(&shown), Some(value), "{}", shown);
    }

    #[test]
    fn no_two_values_show_alike(a in values(), b in values()) {
        let alike = a.show(&Numbered).to_string() == b.show(&Numbered).to_string();
        prop_assert_eq!(alike, a == b);
    }
}

fn hash(value: &Value) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}

/// Generates values of every kind, with small numbers so that equal values occur.
fn values() -> impl Strategy<Value = Value> {
    let real =
        || prop_oneof![any::<f64>(), Just(f64::NAN), Just(-0.0), Just(0.0)].prop_map(Real::new);
    let leaf = prop_oneof![
        Just(Value::Undef),
        any::<bool>().prop_map(Value::Bool),
        (-2_i64..3).prop_map(Value::Int),
        any::<i64>().prop_map(Value::Int),
        real().prop_map(Value::Real),
        any::<char>().prop_map(Value::Char),
        (0_u32..3).prop_map(|each| Value::Atom(Atom(each))),
        (0_u32..3).prop_map(|each| Value::Rule(RuleId(each))),
        any::<String>().prop_map(Value::text),
        (real(), real()).prop_map(|parts| Value::Complex(Arc::new(parts))),
    ];
    leaf.prop_recursive(3, 24, 4, |inner| {
        let many = |least| prop::collection::vec(inner.clone(), least..4);
        prop_oneof![
            many(2).prop_map(Value::tuple),
            many(0).prop_map(Value::seq),
            many(0).prop_map(Value::set),
            many(0).prop_map(Value::bag),
            prop::collection::vec((inner.clone(), inner.clone()), 0..4).prop_map(Value::map),
        ]
    })
}

/// Names atoms `a0`, `a1`, … and rules `r_0`, `r_1`, ….
struct Numbered;

impl ValueNames for Numbered {
    fn atom(&self, atom: Atom, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "a{}", atom.0)
    }

    fn rule(&self, rule: RuleId, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "r_{}", rule.0)
    }
}

/// Parses a complete text written by `show`.
fn read(text: &str) -> Option<Value> {
    let mut reader = Reader { rest: text };
    let value = reader.value()?;
    reader.rest.is_empty().then_some(value)
}

struct Reader<'a> {
    rest: &'a str,
}

impl<'a> Reader<'a> {
    fn value(&mut self) -> Option<Value> {
        let first = self.rest.chars().next()?;
        match first {
            '(' => self.list("(", ")", Self::value).map(Value::tuple),
            '[' => self.list("[", "]", Self::value).map(Value::seq),
            '<' => self.list("<", ">", Self::value).map(Value::bag),
            '{' if self.eat("{->}") => Some(Value::map([])),
            '{' => self.set().or_else(|| self.map()),
            '"' => self.quoted('"').map(Value::text),
            '\'' => self.quoted('\'')?.chars().next().map(Value::Char),
            _ => self.word(),
        }
    }

    fn set(&mut self) -> Option<Value> {
        let start = self.rest;
        let elements: Option<BTreeSet<_>> = self
            .list("{", "}", Self::value)
            .map(|elements| elements.into_iter().collect());
        if elements.is_none() {
            self.rest = start;
        }
        elements.map(|elements| Value::Set(Arc::new(elements)))
    }

    fn map(&mut self) -> Option<Value> {
        let pairs = self.list("{", "}", |reader| {
            let key = reader.value()?;
            reader.eat(" -> ").then_some(())?;
            Some((key, reader.value()?))
        })?;
        Some(Value::Map(Arc::new(BTreeMap::from_iter(pairs))))
    }

    fn list<T>(
        &mut self,
        open: &str,
        close: &str,
        mut item: impl FnMut(&mut Self) -> Option<T>,
    ) -> Option<Vec<T>> {
        self.eat(open).then_some(())?;
        let mut items = Vec::new();
        while !self.eat(close) {
            if !items.is_empty() {
                self.eat(", ").then_some(())?;
            }
            items.push(item(self)?);
        }
        Some(items)
    }

    /// Parses `undef`, `true`, `false`, an atom, a rule or a number, up to the next separator.
    fn word(&mut self) -> Option<Value> {
        let end = self
            .rest
            .find([',', ' ', ')', ']', '}', '>'])
            .unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at_checked(end)?;
        self.rest = rest;
        let number = |prefix| {
            word.strip_prefix(prefix)
                .and_then(|number: &str| number.parse().ok())
        };
        match word {
            "undef" => Some(Value::Undef),
            "true" => Some(Value::Bool(true)),
            "false" => Some(Value::Bool(false)),
            _ => number("a")
                .map(|each| Value::Atom(Atom(each)))
                .or_else(|| number("r_").map(|each| Value::Rule(RuleId(each))))
                .or_else(|| word.parse().ok().map(Value::Int))
                .or_else(|| word.parse().ok().map(Value::real))
                .or_else(|| complex(word)),
        }
    }

    fn quoted(&mut self, quote: char) -> Option<String> {
        let mut read = String::new();
        let mut characters = self.rest.chars();
        characters.next().filter(|&open| open == quote)?;
        loop {
            match characters.next()? {
                '\\' => read.push(match characters.next()? {
                    'n' => '\n',
                    'r' => '\r',
                    't' => '\t',
                    'u' => {
                        let digits: String = characters.by_ref().take(4).collect();
                        char::from_u32(u32::from_str_radix(&digits, 16).ok()?)?
                    }
                    plain => plain,
                }),
                close if close == quote => break,
                plain => read.push(plain),
            }
        }
        self.rest = characters.as_str();
        Some(read)
    }

    fn eat(&mut self, expected: &str) -> bool {
        let rest = self.rest.strip_prefix(expected);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }
}

/// Parses `re+iim` or `re-iim`. The sign that separates the parts is the last one before an `i`: an
/// `inf` in the real part may have a sign before it, but none after it.
fn complex(word: &str) -> Option<Value> {
    let (at, sign) = match word.rfind("+i") {
        Some(at) => (at, 1.0),
        None => (word.rfind("-i")?, -1.0),
    };
    let (re, im) = word.split_at_checked(at)?;
    let re: f64 = re.parse().ok()?;
    let im: f64 = im.get(2..)?.parse().ok()?;
    Some(Value::Complex(Arc::new((
        Real::new(re),
        Real::new(sign * im),
    ))))
}
