//! Shared by the tests of all topics: short names for values, and calls as the machine makes them.

use crate::builtin::{Builtin, BuiltinContext};
use crate::table::{builtin, compatible};
use asmotion_value::{Atom, RuleId, Value, ValueNames};
use std::fmt;

pub(crate) const UNDEF: Value = Value::Undef;
pub(crate) const TRUE: Value = Value::Bool(true);
pub(crate) const FALSE: Value = Value::Bool(false);
pub(crate) const MIN: Value = Value::Int(i64::MIN);
pub(crate) const MAX: Value = Value::Int(i64::MAX);

pub(crate) fn int(number: i64) -> Value {
    Value::Int(number)
}

pub(crate) fn real(number: f64) -> Value {
    Value::real(number)
}

pub(crate) fn text(text: &str) -> Value {
    Value::text(text)
}

pub(crate) fn ints<const N: usize>(numbers: [i64; N]) -> impl Iterator<Item = Value> {
    numbers.into_iter().map(Value::Int)
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

/// Calls a function and compares the text of its value or fault.
#[track_caller]
pub(crate) fn check(name: &str, domain: &str, arguments: &[Value], expected: &str) {
    let (shown, _) = call(builtin(name, domain), arguments);
    assert_eq!(shown, expected, "{name}: {domain} of {arguments:?}");
}

/// Like [`check`], but for `--compat asmeta`.
#[track_caller]
pub(crate) fn check_compatible(name: &str, domain: &str, arguments: &[Value], expected: &str) {
    let (shown, _) = call(compatible(name, domain), arguments);
    assert_eq!(shown, expected, "{name}: {domain} of {arguments:?}");
}

/// Calls a function as the machine does; returns the text of its value or fault, and the printed
/// lines.
pub(crate) fn call(function: Option<&Builtin>, arguments: &[Value]) -> (String, Vec<String>) {
    let mut printed = Vec::new();
    let mut context = BuiltinContext {
        names: &Numbered,
        now_ns: 1_999_999_999,
        printed: &mut printed,
    };
    let shown = match function {
        None => "no such function".to_owned(),
        Some(function) if function.strict && arguments.iter().any(Value::is_undef) => {
            "undef".to_owned()
        }
        Some(function) => match (function.body)(arguments, &mut context) {
            Ok(value) => value.show(&Numbered).to_string(),
            Err(fault) => fault.to_string(),
        },
    };
    (shown, printed)
}
