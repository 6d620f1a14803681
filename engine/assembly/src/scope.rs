//! Values of properties, and what is substituted for them: the one place that asks the environment.

use std::path::Path;
use std::collections::BTreeMap;

use source::{Diagnostic, Report, Sources, Span};

use crate::At;
use crate::environment::{Environment, is_secret};
use crate::finding::{Finding, Findings};
use crate::model::{Amount, Piece, Property, PropertyType, Scalar, Template};
use crate::nearest::{Nearest, Suggest, nearest};
use crate::read::template;
use crate::tree::{Branch, Node};
use crate::value::{REDACTED, Value};

#[derive(Debug, thiserror::Error)]
pub(crate) enum SettingError {
    #[error("the composite has no property `{name}`")]
    Unknown { name: String, at: Option<Span>, nearest: Option<Nearest> },
    #[error("the environment variable `{name}` is not set here")]
    NotSet { name: String, at: Span },
    #[error("`{path}`, which `{name}` names, cannot be read: {reason}")]
    NoSecret { name: String, path: String, reason: String, at: Span },
    #[error("`{name}` takes {wanted}, not {found}")]
    WrongType {
        name: String,
        wanted: String,
        found: &'static str,
        at: Option<Span>,
        declared: Option<Span>,
    },
    #[error("`{name}` is {value}, but must lie in {range}")]
    OutOfRange {
        name: String,
        value: String,
        range: Range,
        at: Option<Span>,
        declared: Option<Span>,
    },
    #[error("the property `{name}` must be set")]
    MustBeSet { name: String, at: Span },
    #[error("a password stands in the file")]
    SecretInFile { at: Span },
}

impl Finding for SettingError {
    fn diagnostic(&self) -> Diagnostic {
        let label = |diagnostic: Diagnostic, at: &Option<Span>, text: String| match at {
            Some(at) => diagnostic.label(*at, text),
            None => diagnostic.note("set from outside the file"),
        };
        match self {
            Self::Unknown { at, nearest, .. } => {
                let diagnostic = label(Diagnostic::error("C013", self), at, "no such property".into());
                match at {
                    Some(at) => diagnostic.suggest(*at, nearest),
                    None => diagnostic,
                }
            }
            Self::NotSet { name, at } => {
                let help = match (name.ends_with("_FILE"), is_secret(name)) {
                    (true, _) => "set it to the path of the file that holds the secret".to_owned(),
                    (false, true) => "set it before the start".to_owned(),
                    (false, false) => format!("set it, or give a default: `${{{name}:-default}}`"),
                };
                Diagnostic::warning("C014", self).label(*at, "needed to start").help(help)
            }
            Self::NoSecret { at, .. } => {
                Diagnostic::warning("C014", self).label(*at, "needed to start")
            }
            Self::WrongType { wanted, at, declared, .. } => {
                let diagnostic =
                    label(Diagnostic::error("C015", self), at, format!("expected {wanted}"));
                match declared {
                    Some(declared) => diagnostic.label(*declared, "declared here"),
                    None => diagnostic,
                }
            }
            Self::OutOfRange { range, at, declared, .. } => {
                let diagnostic =
                    label(Diagnostic::error("C016", self), at, format!("must lie in {range}"));
                match declared {
                    Some(declared) => diagnostic.label(*declared, "the range is declared here"),
                    None => diagnostic,
                }
            }
            Self::MustBeSet { name, at } => Diagnostic::error("C017", self)
                .label(*at, "has no default")
                .help(format!("give it a `default`, or set `{name}` from outside")),
            Self::SecretInFile { at } => Diagnostic::warning("C019", self)
                .label(*at, "everybody who has the file has it")
                .help("name a file with it in a variable: `${AMQP_PASSWORD_FILE}`"),
        }
    }
}

/// What comes up while values are put together.
#[derive(Default)]
pub(crate) struct Notes {
    pub report: Report,
    /// Environment variables that are not set.
    pub missing: Vec<String>,
}

impl Notes {
    fn missing(&mut self, name: &str) {
        if !self.missing.iter().any(|known| known == name) {
            self.missing.push(name.to_owned());
        }
    }
}

impl Findings for Notes {
    fn found(&mut self, finding: impl Finding) {
        self.report.found(finding);
    }
}

/// A range of numbers; open where there is no limit.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Range {
    pub min: Option<f64>,
    pub max: Option<f64>,
    /// A unit to show behind it; empty for none.
    pub unit: String,
}

impl Range {
    pub(crate) fn contains(&self, number: f64) -> bool {
        self.min.is_none_or(|min| number >= min) && self.max.is_none_or(|max| number <= max)
    }
}

impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let space = if self.unit.is_empty() { "" } else { " " };
        let unit = format!("{space}{}", self.unit);
        match (self.min, self.max) {
            (Some(min), Some(max)) => write!(f, "{min} ..= {max}{unit}"),
            (Some(min), None) => write!(f, "{min} ..{unit}"),
            (None, Some(max)) => write!(f, "..= {max}{unit}"),
            (None, None) => f.write_str("any range"),
        }
    }
}

/// The properties of one composite, as they hold in one place of the system.
pub(crate) struct Scope<'s> {
    /// `None` for a value that is not known, which was reported.
    values: BTreeMap<String, (Option<Value>, Span)>,
    environment: &'s dyn Environment,
    sources: &'s Sources,
}

/// A text after substitution.
#[derive(Clone, Debug)]
pub(crate) struct Filled {
    pub text: String,
    /// The same with secrets blotted out.
    pub shown: String,
}

impl Filled {
    fn secret(&self) -> bool {
        self.text != self.shown
    }
}

impl<'s> Scope<'s> {
    /// The properties of a composite, with the values that were `set` from outside.
    pub(crate) fn new(
        properties: &[Property],
        mut set: BTreeMap<String, (Option<Value>, Option<Span>)>,
        environment: &'s dyn Environment,
        sources: &'s Sources,
        notes: &mut Notes,
    ) -> Self {
        let mut scope = Self { values: BTreeMap::new(), environment, sources };
        for property in properties {
            let value = match (set.remove(&property.name.value), &property.default) {
                (Some((value, at)), _) => {
                    let value = value.and_then(|value| accept(property, value, at, notes));
                    value.map(|value| beside(property.kind.value, value, at, sources))
                }
                (None, Some(default)) => {
                    let value = scope.default(property, default, notes);
                    let at = Some(default.span);
                    let value = value.and_then(|value| accept(property, value, at, notes));
                    value.map(|value| beside(property.kind.value, value, at, sources))
                }
                (None, None) => {
                    let (name, at) = (property.name.value.clone(), property.name.span);
                    notes.found(SettingError::MustBeSet { name, at });
                    None
                }
            };
            scope.values.insert(property.name.value.clone(), (value, property.name.span));
        }
        scope
    }

    /// The values that are known, by name.
    pub(crate) fn value(&self, name: &str) -> Option<&Value> {
        self.values.get(name)?.0.as_ref()
    }

    /// The value of a node, with everything substituted; `None` where something is missing.
    pub(crate) fn node(&self, node: &Node, notes: &mut Notes) -> Option<Value> {
        Some(match &node.value {
            Branch::Text(text) => return self.text(text, node.span, notes),
            Branch::Integer(number) => Value::Integer(*number),
            Branch::Float(number) => Value::Real(*number),
            Branch::Boolean(truth) => Value::Boolean(*truth),
            Branch::Date(date) => Value::Text(date.clone()),
            Branch::List(items) => {
                let values: Vec<_> = items.iter().map(|item| self.node(item, notes)).collect();
                Value::List(values.into_iter().collect::<Option<_>>()?)
            }
            Branch::Table(table) => {
                let fields = table.entries.iter().map(|entry| {
                    let value = self.node(&entry.node, notes)?;
                    Some((entry.key.value.clone(), value))
                });
                let fields: Vec<_> = fields.collect();
                Value::Record(fields.into_iter().collect::<Option<_>>()?)
            }
        })
    }

    /// A default; what the environment gives is text, also where a number is wanted.
    fn default(&self, property: &Property, node: &Node, notes: &mut Notes) -> Option<Value> {
        let value = self.node(node, notes)?;
        match (&value, &node.value) {
            (Value::Text(filled), Branch::Text(written)) if filled != written => {
                from_text(filled, property.kind.value).or(Some(value))
            }
            _ => Some(value),
        }
    }

    /// A text that is nothing but a property is that property, number or not.
    fn text(&self, text: &str, span: Span, notes: &mut Notes) -> Option<Value> {
        let exact = self.sources.snippet(span) == text;
        let template = template::parse(text, span, exact).ok()?;
        if let [Piece::Property { name, span }] = template.pieces.as_slice() {
            return self.property(name, *span, notes).cloned();
        }
        let filled = self.fill(&template, notes)?;
        Some(match filled.secret() {
            true => Value::Secret(filled.text),
            false => Value::Text(filled.text),
        })
    }

    fn property(&self, name: &str, at: Span, notes: &mut Notes) -> Option<&Value> {
        match self.values.get(name) {
            Some((value, _)) => value.as_ref(),
            None => {
                let known = self.values.iter().map(|(name, (_, at))| (name.as_str(), Some(*at)));
                let nearest = nearest(name, known);
                notes.found(SettingError::Unknown { name: name.to_owned(), at: Some(at), nearest });
                None
            }
        }
    }

    /// A text with everything substituted; `None` where something is missing.
    pub(crate) fn fill(&self, template: &Template, notes: &mut Notes) -> Option<Filled> {
        let mut text = String::new();
        let mut shown = String::new();
        let mut complete = true;
        for piece in &template.pieces {
            let filled = match piece {
                Piece::Text(plain) => Some((plain.clone(), false)),
                Piece::Property { name, span } => {
                    self.property(name, *span, notes).map(plain)
                }
                Piece::Variable { name, default, span } => {
                    self.variable(name, default.as_deref(), *span, notes)
                }
            };
            match filled {
                Some((piece, secret)) => {
                    shown.push_str(if secret { REDACTED } else { &piece });
                    text.push_str(&piece);
                }
                None => complete = false,
            }
        }
        complete.then_some(Filled { text, shown })
    }

    /// A variable, and whether it is a secret. One that ends in `_FILE` names a file with a secret.
    fn variable(
        &self,
        name: &str,
        default: Option<&str>,
        at: Span,
        notes: &mut Notes,
    ) -> Option<(String, bool)> {
        let value = self.environment.variable(name).filter(|value| !value.is_empty());
        let Some(value) = value.or(default.map(str::to_owned)) else {
            notes.missing(name);
            notes.found(SettingError::NotSet { name: name.to_owned(), at });
            return None;
        };
        if !name.ends_with("_FILE") {
            return Some((value, is_secret(name)));
        }
        match self.environment.secret(&value) {
            Ok(text) => Some((text.trim_end_matches(['\r', '\n']).to_owned(), true)),
            Err(reason) => {
                notes.missing(name);
                let (name, path) = (name.to_owned(), value);
                notes.found(SettingError::NoSecret { name, path, reason, at });
                None
            }
        }
    }

    /// A whole number that may come from a property.
    pub(crate) fn amount(
        &self,
        name: &str,
        amount: &At<Amount>,
        range: std::ops::RangeInclusive<i64>,
        notes: &mut Notes,
    ) -> Option<i64> {
        let template = match &amount.value {
            Amount::Number(number) => return Some(*number),
            Amount::Template(template) => template,
        };
        let value = match template.pieces.as_slice() {
            [Piece::Property { name, span }] => self.property(name, *span, notes)?.clone(),
            _ => Value::Text(self.fill(template, notes)?.text),
        };
        let number = match &value {
            Value::Integer(number) => Some(*number),
            Value::Real(number) if number.fract() == 0.0 => Some(*number as i64),
            Value::Text(text) => text.trim().parse().ok(),
            Value::Real(_)
            | Value::Boolean(_)
            | Value::Secret(_)
            | Value::List(_)
            | Value::Record(_) => None,
        };
        let Some(number) = number else {
            notes.found(SettingError::WrongType {
                name: name.to_owned(),
                wanted: "a whole number".to_owned(),
                found: value.describe(),
                at: Some(amount.span),
                declared: None,
            });
            return None;
        };
        if !range.contains(&number) {
            let (min, max) = (Some(*range.start() as f64), Some(*range.end() as f64));
            notes.found(SettingError::OutOfRange {
                name: name.to_owned(),
                value: number.to_string(),
                range: Range { min, max, unit: String::new() },
                at: Some(amount.span),
                declared: None,
            });
            return None;
        }
        Some(number)
    }
}

/// A value as text, and whether it is a secret.
fn plain(value: &Value) -> (String, bool) {
    match value {
        Value::Text(text) => (text.clone(), false),
        Value::Secret(text) => (text.clone(), true),
        Value::Boolean(_) | Value::Integer(_) | Value::Real(_) | Value::List(_)
        | Value::Record(_) => (value.to_string(), false),
    }
}

/// A path counts from the folder of the file it is written in, wherever the run is begun.
fn beside(kind: PropertyType, value: Value, at: Option<Span>, sources: &Sources) -> Value {
    let Some(at) = at.filter(|_| kind.scalar == Scalar::Path) else {
        return value;
    };
    match value {
        Value::Text(path) => {
            let folder = Path::new(sources.path(at.file)).parent().unwrap_or(Path::new(""));
            Value::Text(folder.join(path).display().to_string())
        }
        Value::List(paths) => {
            let paths = paths.into_iter().map(|path| beside(kind, path, Some(at), sources));
            Value::List(paths.collect())
        }
        other => other,
    }
}

/// A value for a property of a composite, if it has its type and lies in its range.
fn accept(
    property: &Property,
    value: Value,
    at: Option<Span>,
    notes: &mut Notes,
) -> Option<Value> {
    let name = &property.name.value;
    let declared = Some(property.kind.span);
    let found = value.describe();
    let Some(value) = of_type(value, property.kind.value) else {
        notes.found(SettingError::WrongType {
            name: name.clone(),
            wanted: describe(property.kind.value),
            found,
            at,
            declared,
        });
        return None;
    };
    let (least, greatest) = limits(property.kind.scalar);
    let range = Range {
        min: property.min.as_ref().map(|min| min.value).or(least),
        max: property.max.as_ref().map(|max| max.value).or(greatest),
        unit: String::new(),
    };
    let limit = property.min.as_ref().or(property.max.as_ref());
    let declared = limit.map(|limit| limit.span).or(declared);
    within(name, &value, &range, at, declared, notes).then_some(value)
}

/// Whether all numbers of a value lie in a range.
pub(crate) fn within(
    name: &str,
    value: &Value,
    range: &Range,
    at: Option<Span>,
    declared: Option<Span>,
    notes: &mut Notes,
) -> bool {
    if let Value::List(items) = value {
        return items.iter().all(|item| within(name, item, range, at, declared, notes));
    }
    match value.number() {
        Some(number) if !range.contains(number) => {
            let (name, value) = (name.to_owned(), value.to_string());
            let range = range.clone();
            notes.found(SettingError::OutOfRange { name, value, range, at, declared });
            false
        }
        Some(_) | None => true,
    }
}

/// What a property takes, for people.
fn describe(kind: PropertyType) -> String {
    let one = match kind.scalar {
        Scalar::Text | Scalar::Uri | Scalar::Path | Scalar::Secret => "text",
        Scalar::Boolean => "Boolean",
        Scalar::F32 | Scalar::F64 => "number",
        Scalar::I8
        | Scalar::I16
        | Scalar::I32
        | Scalar::I64
        | Scalar::U8
        | Scalar::U16
        | Scalar::U32
        | Scalar::U64 => "whole number",
    };
    match kind.list {
        true => format!("a list of {one}s"),
        false => format!("a {one}"),
    }
}

/// The numbers a type can hold.
fn limits(scalar: Scalar) -> (Option<f64>, Option<f64>) {
    match scalar {
        Scalar::I8 => (Some(i8::MIN.into()), Some(i8::MAX.into())),
        Scalar::I16 => (Some(i16::MIN.into()), Some(i16::MAX.into())),
        Scalar::I32 => (Some(i32::MIN.into()), Some(i32::MAX.into())),
        Scalar::U8 => (Some(0.0), Some(u8::MAX.into())),
        Scalar::U16 => (Some(0.0), Some(u16::MAX.into())),
        Scalar::U32 => (Some(0.0), Some(u32::MAX.into())),
        Scalar::U64 => (Some(0.0), None),
        Scalar::I64
        | Scalar::F32
        | Scalar::F64
        | Scalar::Text
        | Scalar::Boolean
        | Scalar::Uri
        | Scalar::Path
        | Scalar::Secret => (None, None),
    }
}

/// A value as a type wants it.
fn of_type(value: Value, kind: PropertyType) -> Option<Value> {
    if kind.list {
        let Value::List(items) = value else {
            return None;
        };
        let scalar = PropertyType { list: false, ..kind };
        let items = items.into_iter().map(|item| of_type(item, scalar));
        return items.collect::<Option<_>>().map(Value::List);
    }
    match (kind.scalar, value) {
        (Scalar::Text | Scalar::Uri | Scalar::Path, value @ (Value::Text(_) | Value::Secret(_))) => {
            Some(value)
        }
        (Scalar::Secret, Value::Text(text) | Value::Secret(text)) => Some(Value::Secret(text)),
        (Scalar::Boolean, value @ Value::Boolean(_)) => Some(value),
        (Scalar::F32 | Scalar::F64, Value::Integer(number)) => Some(Value::Real(number as f64)),
        (Scalar::F32 | Scalar::F64, value @ Value::Real(_)) => Some(value),
        (
            Scalar::I8
            | Scalar::I16
            | Scalar::I32
            | Scalar::I64
            | Scalar::U8
            | Scalar::U16
            | Scalar::U32
            | Scalar::U64,
            value @ Value::Integer(_),
        ) => Some(value),
        (_, _) => None,
    }
}

/// A text from outside, as a property of this type takes it.
pub(crate) fn from_text(text: &str, kind: PropertyType) -> Option<Value> {
    if kind.list {
        let scalar = PropertyType { list: false, ..kind };
        let items = text.split(',').map(|item| from_text(item.trim(), scalar));
        return items.collect::<Option<_>>().map(Value::List);
    }
    match kind.scalar {
        Scalar::Text | Scalar::Uri | Scalar::Path => Some(Value::Text(text.to_owned())),
        Scalar::Secret => Some(Value::Secret(text.to_owned())),
        Scalar::Boolean => text.parse().ok().map(Value::Boolean),
        Scalar::F32 | Scalar::F64 => text.parse().ok().map(Value::Real),
        Scalar::I8
        | Scalar::I16
        | Scalar::I32
        | Scalar::I64
        | Scalar::U8
        | Scalar::U16
        | Scalar::U32
        | Scalar::U64 => text.parse().ok().map(Value::Integer),
    }
}
