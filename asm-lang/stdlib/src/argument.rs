//! Conversion between values and typed arguments, which makes a body a plain Rust function.

use crate::fault::BuiltinFault;
use asmotion_value::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// A Rust type for arguments.
pub(crate) trait FromValue<'a>: Sized {
    /// Description of the expected value, for messages.
    const EXPECTED: &'static str;

    /// Converts a value; returns `None` if it has another shape.
    fn read(value: &'a Value) -> Option<Self>;
}

/// A Rust type for results.
pub(crate) trait IntoValue {
    /// Converts to a value.
    fn answer(self) -> Result<Value, BuiltinFault>;
}

/// The components of a tuple, as opposed to a plain slice, which stands for a sequence.
pub(crate) struct TupleArguments<'a>(pub &'a [Value]);

/// Calls a function of one argument.
pub(crate) fn unary<'a, A: FromValue<'a>, R: IntoValue>(
    arguments: &'a [Value],
    function: impl FnOnce(A) -> R,
) -> Result<Value, BuiltinFault> {
    match arguments {
        [a] => function(read(a)?).answer(),
        _ => Err(arity("one argument")),
    }
}

/// Calls a function of two arguments.
pub(crate) fn binary<'a, A: FromValue<'a>, B: FromValue<'a>, R: IntoValue>(
    arguments: &'a [Value],
    function: impl FnOnce(A, B) -> R,
) -> Result<Value, BuiltinFault> {
    match arguments {
        [a, b] => function(read(a)?, read(b)?).answer(),
        _ => Err(arity("two arguments")),
    }
}

/// Calls a function of three arguments.
pub(crate) fn ternary<'a, A: FromValue<'a>, B: FromValue<'a>, C: FromValue<'a>, R: IntoValue>(
    arguments: &'a [Value],
    function: impl FnOnce(A, B, C) -> R,
) -> Result<Value, BuiltinFault> {
    match arguments {
        [a, b, c] => function(read(a)?, read(b)?, read(c)?).answer(),
        _ => Err(arity("three arguments")),
    }
}

/// Returns the kind of a value in words.
pub(crate) fn kind(value: &Value) -> &'static str {
    match value {
        Value::Undef => "undef",
        Value::Bool(_) => "a Boolean",
        Value::Int(_) => "an Integer",
        Value::Real(_) => "a Real",
        Value::Char(_) => "a Char",
        Value::Atom(_) => "an element without structure",
        Value::Rule(_) => "a rule",
        Value::Text(_) => "a String",
        Value::Complex(_) => "a Complex",
        Value::Tuple(_) => "a tuple",
        Value::Seq(_) => "a sequence",
        Value::Set(_) => "a set",
        Value::Bag(_) => "a bag",
        Value::Map(_) => "a map",
    }
}

fn read<'a, A: FromValue<'a>>(value: &'a Value) -> Result<A, BuiltinFault> {
    A::read(value).ok_or(BuiltinFault::Shape {
        expected: A::EXPECTED,
        found: kind(value),
    })
}

fn arity(expected: &'static str) -> BuiltinFault {
    BuiltinFault::Shape {
        expected,
        found: "a different number",
    }
}

impl<'a> FromValue<'a> for &'a Value {
    const EXPECTED: &'static str = "a value";
    fn read(value: &'a Value) -> Option<Self> {
        Some(value)
    }
}

/// `None` stands for `undef`.
impl<'a, A: FromValue<'a>> FromValue<'a> for Option<A> {
    const EXPECTED: &'static str = A::EXPECTED;
    fn read(value: &'a Value) -> Option<Self> {
        if value.is_undef() {
            Some(None)
        } else {
            A::read(value).map(Some)
        }
    }
}

/// Implements [`FromValue`] for the Rust type of one shape of values.
macro_rules! shape {
    ($type:ty, $expected:literal, $pattern:pat => $argument:expr) => {
        impl<'a> FromValue<'a> for $type {
            const EXPECTED: &'static str = $expected;
            fn read(value: &'a Value) -> Option<Self> {
                if let $pattern = value {
                    Some($argument)
                } else {
                    None
                }
            }
        }
    };
}

shape!(bool, "a Boolean", Value::Bool(truth) => *truth);
shape!(i64, "an Integer or a Natural", Value::Int(number) => *number);
shape!(f64, "a Real", Value::Real(number) => number.get());
shape!(char, "a Char", Value::Char(character) => *character);
shape!(&'a str, "a String", Value::Text(text) => text);
shape!(&'a [Value], "a sequence", Value::Seq(elements) => elements);
shape!(TupleArguments<'a>, "a tuple", Value::Tuple(components) => TupleArguments(components));
shape!(&'a BTreeSet<Value>, "a set", Value::Set(elements) => elements);
shape!(&'a BTreeMap<Value, usize>, "a bag", Value::Bag(elements) => elements);
shape!(&'a BTreeMap<Value, Value>, "a map", Value::Map(pairs) => pairs);

impl IntoValue for Value {
    fn answer(self) -> Result<Value, BuiltinFault> {
        Ok(self)
    }
}

impl IntoValue for &Value {
    fn answer(self) -> Result<Value, BuiltinFault> {
        Ok(self.clone())
    }
}

/// `None` stands for `undef`.
impl<R: IntoValue> IntoValue for Option<R> {
    fn answer(self) -> Result<Value, BuiltinFault> {
        self.map_or(Ok(Value::Undef), R::answer)
    }
}

impl<R: IntoValue> IntoValue for Result<R, BuiltinFault> {
    fn answer(self) -> Result<Value, BuiltinFault> {
        self.and_then(R::answer)
    }
}

impl IntoValue for bool {
    fn answer(self) -> Result<Value, BuiltinFault> {
        Ok(Value::Bool(self))
    }
}

impl IntoValue for i64 {
    fn answer(self) -> Result<Value, BuiltinFault> {
        Ok(Value::Int(self))
    }
}

impl IntoValue for f64 {
    fn answer(self) -> Result<Value, BuiltinFault> {
        Ok(Value::real(self))
    }
}

impl IntoValue for char {
    fn answer(self) -> Result<Value, BuiltinFault> {
        Ok(Value::Char(self))
    }
}

impl IntoValue for String {
    fn answer(self) -> Result<Value, BuiltinFault> {
        Ok(Value::text(self))
    }
}

impl IntoValue for Vec<Value> {
    fn answer(self) -> Result<Value, BuiltinFault> {
        Ok(Value::Seq(Arc::new(self)))
    }
}

impl IntoValue for BTreeSet<Value> {
    fn answer(self) -> Result<Value, BuiltinFault> {
        Ok(Value::Set(Arc::new(self)))
    }
}

impl IntoValue for BTreeMap<Value, usize> {
    fn answer(self) -> Result<Value, BuiltinFault> {
        Ok(Value::Bag(Arc::new(self)))
    }
}

impl IntoValue for BTreeMap<Value, Value> {
    fn answer(self) -> Result<Value, BuiltinFault> {
        Ok(Value::Map(Arc::new(self)))
    }
}
