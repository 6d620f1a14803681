//! Conditions over the observed state of a run, in three-valued logic: a part without a value yet is unknown.

use std::fmt;

use asmotion_datum::Datum;

use crate::codes::v032::InvalidRunCondition;
use asmotion_story::brief::brief;

/// The result of reading or resolving a part of a condition.
pub(super) type ConditionResult<T> = Result<T, Box<InvalidRunCondition>>;

/// A condition; operands are positions in the list of observed values.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum RunCondition {
    Not(Box<RunCondition>),
    And(Box<RunCondition>, Box<RunCondition>),
    Or(Box<RunCondition>, Box<RunCondition>),
    Compare {
        operand: usize,
        relation: Relation,
        with: ObservedValue,
    },
}

/// Relation of an operand to a literal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Relation {
    Equal,
    NotEqual,
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
}

/// A value of an operand.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum ObservedValue {
    Number(f64),
    Truth(bool),
    Text(String),
}

impl RunCondition {
    /// Evaluates the condition; `None` if it depends on a value that is not known yet.
    pub(super) fn evaluate(&self, values: &[Option<ObservedValue>]) -> Option<bool> {
        match self {
            Self::Not(inner) => inner.evaluate(values).map(|truth| !truth),
            Self::And(left, right) => match (left.evaluate(values), right.evaluate(values)) {
                (Some(false), _) | (_, Some(false)) => Some(false),
                (Some(true), Some(true)) => Some(true),
                (None, _) | (_, None) => None,
            },
            Self::Or(left, right) => match (left.evaluate(values), right.evaluate(values)) {
                (Some(true), _) | (_, Some(true)) => Some(true),
                (Some(false), Some(false)) => Some(false),
                (None, _) | (_, None) => None,
            },
            Self::Compare {
                operand,
                relation,
                with,
            } => {
                let value = values.get(*operand)?.as_ref()?;
                Some(relation.holds(value, with))
            }
        }
    }

    /// The operands of the condition, in order of occurrence.
    pub(super) fn operands(&self) -> Vec<usize> {
        match self {
            Self::Not(inner) => inner.operands(),
            Self::And(left, right) | Self::Or(left, right) => {
                let mut operands = left.operands();
                let more = right.operands().into_iter();
                operands.extend(more.filter(|it| !left.operands().contains(it)));
                operands
            }
            Self::Compare { operand, .. } => vec![*operand],
        }
    }
}

impl Relation {
    fn holds(self, left: &ObservedValue, right: &ObservedValue) -> bool {
        use ObservedValue::Number;
        match (self, left, right) {
            (Self::Equal, left, right) => left == right,
            (Self::NotEqual, left, right) => left != right,
            (Self::Less, Number(left), Number(right)) => left < right,
            (Self::LessOrEqual, Number(left), Number(right)) => left <= right,
            (Self::Greater, Number(left), Number(right)) => left > right,
            (Self::GreaterOrEqual, Number(left), Number(right)) => left >= right,
            (Self::Less | Self::LessOrEqual | Self::Greater | Self::GreaterOrEqual, _, _) => false,
        }
    }

    /// Whether the relation compares magnitudes.
    pub(super) fn is_order(self) -> bool {
        !matches!(self, Self::Equal | Self::NotEqual)
    }
}

impl ObservedValue {
    /// The value of a literal without quotes, or of a location that is no element of String.
    pub(super) fn of_text(text: &str) -> Self {
        match (text.parse(), text) {
            (Ok(number), _) => Self::Number(number),
            (Err(_), "true") => Self::Truth(true),
            (Err(_), "false") => Self::Truth(false),
            (Err(_), text) => Self::Text(text.to_owned()),
        }
    }

    /// The value of a location in the notation of traces, where elements of String have quotes.
    pub(super) fn of_location(text: &str) -> Self {
        match serde_json::from_str::<String>(text) {
            Ok(unquoted) => Self::Text(unquoted),
            Err(_) => Self::of_text(text),
        }
    }

    /// The value of a field; `None` for null, lists and records.
    pub(super) fn of_datum(datum: &Datum) -> Option<Self> {
        match datum {
            Datum::Bool(truth) => Some(Self::Truth(*truth)),
            Datum::Int(number) => Some(Self::Number(*number as f64)),
            Datum::Float(number) => Some(Self::Number(*number)),
            Datum::Text(text) => Some(Self::Text(text.clone())),
            Datum::Null
            | Datum::Bytes(_)
            | Datum::Numbers(_)
            | Datum::List(_)
            | Datum::Record(_) => None,
        }
    }

    /// Describes the type for messages.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Number(_) => "a number",
            Self::Truth(_) => "a Boolean",
            Self::Text(_) => "a text",
        }
    }
}

impl fmt::Display for ObservedValue {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => to.write_str(&brief(&Datum::Float(*number))),
            Self::Truth(truth) => truth.fmt(to),
            Self::Text(text) => text.fmt(to),
        }
    }
}
