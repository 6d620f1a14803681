//! Functions for every domain: equality, `isDef`, conversion to strings, output.

use crate::argument::{binary, unary};
use crate::builtin::{Builtin, BuiltinBody, BuiltinContext, strict, total};
use crate::fault::BuiltinFault;
use crate::to_string::{TO_STRING, to_string};
use asmotion_value::{Value, ValueNames};

/// Returns `true` if two values are equal. Total: `undef` equals `undef`, reals compare by bits
/// (`NaN = NaN`, and `-0.0` differs from `0.0`), collections by content.
#[inline]
pub fn eq(left: &Value, right: &Value) -> bool {
    left == right
}

/// Returns `true` if an integer (or natural) and a real are exactly the same number; `2^53 + 1`
/// equals no double.
pub fn same_number(integer: i64, real: f64) -> bool {
    // a double outside this range is no i64; inside it, truncation is exact
    const END: f64 = 9_223_372_036_854_775_808.0;
    (-END..END).contains(&real) && real.fract() == 0.0 && real as i64 == integer
}

const EQ: BuiltinBody = |arguments, _| binary(arguments, eq);
const NEQ: BuiltinBody = |arguments, _| binary(arguments, |a: &Value, b: &Value| !eq(a, b));

fn mixed(integer: Option<i64>, real: Option<f64>) -> bool {
    match (integer, real) {
        (Some(integer), Some(real)) => same_number(integer, real),
        (integer, real) => integer.is_none() && real.is_none(),
    }
}

const EQ_REAL: BuiltinBody = |arguments, _| binary(arguments, mixed);
const EQ_INTEGER: BuiltinBody =
    |arguments, _| binary(arguments, |real, integer| mixed(integer, real));
const NEQ_REAL: BuiltinBody =
    |arguments, _| binary(arguments, |integer, real| !mixed(integer, real));
const NEQ_INTEGER: BuiltinBody =
    |arguments, _| binary(arguments, |real, integer| !mixed(integer, real));

/// Writes the values on one line, separated by blanks, and returns their number.
fn print(arguments: &[Value], context: &mut BuiltinContext<'_>) -> Result<Value, BuiltinFault> {
    let words: Vec<String> = arguments
        .iter()
        .map(|value| to_string(value, context.names))
        .collect();
    context.printed.push(words.join(" "));
    Ok(Value::Int(crate::integer::of(arguments.len())))
}

pub(crate) const TABLE: &[Builtin] = &[
    total("eq", "Prod(D,D)", EQ),
    total("eq", "Prod(Agent,Agent)", EQ),
    total("eq", "Prod(Natural,Integer)", EQ),
    total("eq", "Prod(Integer,Natural)", EQ),
    total("eq", "Prod(Natural,Real)", EQ_REAL),
    total("eq", "Prod(Integer,Real)", EQ_REAL),
    total("eq", "Prod(Real,Natural)", EQ_INTEGER),
    total("eq", "Prod(Real,Integer)", EQ_INTEGER),
    total("neq", "Prod(D,D)", NEQ),
    total("neq", "Prod(Agent,Agent)", NEQ),
    total("neq", "Prod(Natural,Integer)", NEQ),
    total("neq", "Prod(Integer,Natural)", NEQ),
    total("neq", "Prod(Natural,Real)", NEQ_REAL),
    total("neq", "Prod(Integer,Real)", NEQ_REAL),
    total("neq", "Prod(Real,Natural)", NEQ_INTEGER),
    total("neq", "Prod(Real,Integer)", NEQ_INTEGER),
    total("isDef", "D", |arguments, _| {
        unary(arguments, |value: &Value| !value.is_undef())
    }),
    total("isUndef", "D", |arguments, _| {
        unary(arguments, Value::is_undef)
    }),
    // outside `seq`, terms are evaluated in the state before the step anyway; within, the machine
    // evaluates `pre` itself
    total("pre", "D", |arguments, _| {
        unary(arguments, |value: &Value| value.clone())
    }),
    strict("toString", "D", TO_STRING),
    total("print", "D", print),
    total("print", "Prod(D,D1)", print),
    total("print", "Prod(D,D1,D2)", print),
    total("print", "Prod(D,D1,D2,D3)", print),
    total("print", "Prod(D,D1,D2,D3,D4)", print),
    total("print", "Prod(D,D1,D2,D3,D4,D5)", print),
    total("print", "Prod(D,D1,D2,D3,D4,D5,D6)", print),
    total("print", "Prod(D,D1,D2,D3,D4,D5,D6,D7)", print),
    total("print", "Prod(D,D1,D2,D3,D4,D5,D6,D7,D8)", print),
    total("print", "Prod(D,D1,D2,D3,D4,D5,D6,D7,D8,D9)", print),
];

/// Functions that differ in the reference tools: sets are written like sequences, tuples without
/// blanks.
pub(crate) const COMPATIBLE: &[Builtin] = &[strict("toString", "D", |arguments, context| {
    unary(arguments, |value: &Value| to_list(value, context.names))
})];

fn to_list(value: &Value, names: &dyn ValueNames) -> String {
    let all = |items: &mut dyn Iterator<Item = &Value>, separator: &str| {
        let items: Vec<String> = items.map(|item| to_list(item, names)).collect();
        items.join(separator)
    };
    match value {
        Value::Set(items) => format!("[{}]", all(&mut items.iter(), ", ")),
        Value::Seq(items) => format!("[{}]", all(&mut items.iter(), ", ")),
        Value::Tuple(items) => format!("({})", all(&mut items.iter(), ",")),
        Value::Undef
        | Value::Bool(_)
        | Value::Int(_)
        | Value::Real(_)
        | Value::Char(_)
        | Value::Text(_)
        | Value::Complex(_)
        | Value::Atom(_)
        | Value::Rule(_)
        | Value::Bag(_)
        | Value::Map(_) => to_string(value, names),
    }
}

#[cfg(test)]
mod tests {
    use super::same_number;
    use crate::builtin;
    use crate::testing::*;
    use asmotion_value::{Atom, RuleId, Value};

    /// Pairs of a value and a similar one, for every kind of value.
    fn pairs() -> Vec<(Value, Value)> {
        vec![
            (TRUE, FALSE),
            (int(1), int(2)),
            (real(0.0), real(-0.0)),
            (real(f64::NAN), real(1.0)),
            (Value::Char('a'), Value::Char('b')),
            (Value::Atom(Atom(0)), Value::Atom(Atom(1))),
            (Value::Rule(RuleId(0)), Value::Rule(RuleId(1))),
            (text("a"), text("A")),
            (Value::tuple(ints([1, 2])), Value::tuple(ints([2, 1]))),
            (Value::seq(ints([1, 2])), Value::seq(ints([2, 1]))),
            (Value::set(ints([1, 2])), Value::set(ints([1]))),
            (Value::bag(ints([1, 1])), Value::bag(ints([1]))),
            (Value::map([(int(1), TRUE)]), Value::map([(int(1), FALSE)])),
        ]
    }

    #[test]
    fn equality_is_total() {
        for (value, other) in pairs() {
            for domain in ["Prod(D,D)", "Prod(Agent,Agent)"] {
                check("eq", domain, &[value.clone(), value.clone()], "true");
                check("neq", domain, &[value.clone(), value.clone()], "false");
                check("eq", domain, &[value.clone(), other.clone()], "false");
                check("neq", domain, &[value.clone(), other.clone()], "true");
                check("eq", domain, &[value.clone(), UNDEF], "false");
                check("neq", domain, &[UNDEF, value.clone()], "true");
            }
        }
        check("eq", "Prod(D,D)", &[UNDEF, UNDEF], "true");
        check("neq", "Prod(D,D)", &[UNDEF, UNDEF], "false");
        check(
            "eq",
            "Prod(D,D)",
            &[Value::bag(ints([2, 1, 2])), Value::bag(ints([2, 2, 1]))],
            "true",
        );
    }

    #[test]
    fn numbers_of_two_domains_compare_exactly() {
        check("eq", "Prod(Natural,Integer)", &[int(3), int(3)], "true");
        check("neq", "Prod(Integer,Natural)", &[int(-3), int(3)], "true");
        for (integer, number, same) in [
            (2, 2.0, true),
            (2, 2.5, false),
            (0, -0.0, true),
            (0, f64::NAN, false),
        ] {
            let (integer, number) = (int(integer), real(number));
            let (yes, no) = (same.to_string(), (!same).to_string());
            check(
                "eq",
                "Prod(Integer,Real)",
                &[integer.clone(), number.clone()],
                &yes,
            );
            check(
                "neq",
                "Prod(Integer,Real)",
                &[integer.clone(), number.clone()],
                &no,
            );
            check(
                "eq",
                "Prod(Real,Natural)",
                &[number.clone(), integer.clone()],
                &yes,
            );
            check("neq", "Prod(Real,Natural)", &[number, integer], &no);
        }
        check("eq", "Prod(Integer,Real)", &[UNDEF, UNDEF], "true");
        check("eq", "Prod(Real,Integer)", &[real(1.0), UNDEF], "false");
        check("neq", "Prod(Natural,Real)", &[UNDEF, real(1.0)], "true");
        assert!(
            !same_number((1 << 53) + 1, 9_007_199_254_740_992.0),
            "2^53 is its neighbour"
        );
        assert!(
            !same_number(i64::MAX, 9_223_372_036_854_775_808.0),
            "2^63 is its neighbour"
        );
        assert!(same_number(i64::MIN, -9_223_372_036_854_775_808.0));
        assert!(!same_number(i64::MAX, f64::INFINITY));
    }

    #[test]
    fn definedness_is_total() {
        check("isDef", "D", &[UNDEF], "false");
        check("isUndef", "D", &[UNDEF], "true");
        for (value, _) in pairs() {
            check("isDef", "D", std::slice::from_ref(&value), "true");
            check("isUndef", "D", &[value], "false");
        }
        check("isDef", "D", &[Value::set([UNDEF])], "true");
        check("pre", "D", &[int(1)], "1");
        check("pre", "D", &[UNDEF], "undef");
    }

    #[test]
    fn texts_and_characters_lose_their_quotes() {
        check("toString", "D", &[text("a \"b\"")], r#""a \"b\"""#);
        check("toString", "D", &[Value::Char('c')], r#""c""#);
        check("toString", "Integer", &[MIN], r#""-9223372036854775808""#);
        check("toString", "Natural", &[int(0)], r#""0""#);
        check("toString", "Real", &[real(1.5)], r#""1.5""#);
        check("toString", "Char", &[Value::Char('\'')], r#""'""#);
        check("toString", "D", &[Value::set(ints([2, 1]))], r#""{1, 2}""#);
        check("toString", "D", &[Value::Atom(Atom(7))], r#""a7""#);
        check("toString", "D", &[UNDEF], "undef");
    }

    #[test]
    fn print_writes_a_line_and_counts() {
        let (count, printed) = call(
            builtin("print", "Prod(D,D1,D2)"),
            &[text("at"), int(3), UNDEF],
        );
        assert_eq!(
            (count.as_str(), printed),
            ("3", vec!["at 3 undef".to_owned()])
        );
        let (count, printed) = call(builtin("print", "D"), &[real(0.5)]);
        assert_eq!((count.as_str(), printed), ("1", vec!["0.5".to_owned()]));
    }
}
