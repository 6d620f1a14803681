//! `sum` over sets and bags of numbers.

use crate::argument::{kind, unary};
use crate::builtin::{Builtin, strict};
use crate::collection::BagValue;
use crate::collection::SetValue;
use crate::complex::{self, Complex};
use crate::fault::BuiltinFault;
use crate::{integer, real};
use asmotion_value::Value;

/// Adds numbers of one domain with their multiplicities. Returns `zero` for no numbers, and `undef`
/// if one of them is.
fn sum<'a>(
    zero: Value,
    numbers: impl Iterator<Item = (&'a Value, usize)>,
) -> Result<Value, BuiltinFault> {
    let mut sum = None;
    for (number, times) in numbers {
        let number = repeated(number, times)?;
        sum = Some(match sum {
            None => number,
            Some(sum) => plus(&sum, &number)?,
        });
    }
    Ok(sum.unwrap_or(zero))
}

/// Multiplies a number by its multiplicity.
fn repeated(number: &Value, times: usize) -> Result<Value, BuiltinFault> {
    let times = integer::of(times);
    match number {
        Value::Undef => Ok(Value::Undef),
        Value::Int(number) => integer::mult(*number, times).map(Value::Int),
        Value::Real(number) => Ok(Value::real(integer::to_real(times) * number.get())),
        Value::Complex(parts) => {
            Ok(complex::scale(integer::to_real(times), Complex::from(**parts)).value())
        }
        Value::Bool(_)
        | Value::Char(_)
        | Value::Atom(_)
        | Value::Rule(_)
        | Value::Text(_)
        | Value::Tuple(_)
        | Value::Seq(_)
        | Value::Set(_)
        | Value::Bag(_)
        | Value::Map(_) => Err(BuiltinFault::Sum {
            left: "a number",
            right: kind(number),
        }),
    }
}

fn plus(left: &Value, right: &Value) -> Result<Value, BuiltinFault> {
    match (left, right) {
        (Value::Undef, _) | (_, Value::Undef) => Ok(Value::Undef),
        (Value::Int(left), Value::Int(right)) => integer::plus(*left, *right).map(Value::Int),
        (Value::Real(left), Value::Real(right)) => {
            Ok(Value::real(real::plus(left.get(), right.get())))
        }
        (Value::Complex(left), Value::Complex(right)) => {
            Ok(complex::plus(Complex::from(**left), Complex::from(**right)).value())
        }
        (left, right) => Err(BuiltinFault::Sum {
            left: kind(left),
            right: kind(right),
        }),
    }
}

fn of_set(zero: Value, set: &SetValue) -> Result<Value, BuiltinFault> {
    sum(zero, set.iter().map(|number| (number, 1)))
}

fn of_bag(zero: Value, bag: &BagValue) -> Result<Value, BuiltinFault> {
    sum(zero, bag.iter().map(|(number, &times)| (number, times)))
}

pub(crate) const TABLE: &[Builtin] = &[
    strict("sum", "Powerset(D)", |arguments, _| {
        unary(arguments, |set| of_set(Value::Int(0), set))
    }),
    strict("sum", "Powerset(Real)", |arguments, _| {
        unary(arguments, |set| of_set(Value::real(0.0), set))
    }),
    strict("sum", "Bag(D)", |arguments, _| {
        unary(arguments, |bag| of_bag(Value::Int(0), bag))
    }),
    strict("sum", "Bag(Real)", |arguments, _| {
        unary(arguments, |bag| of_bag(Value::real(0.0), bag))
    }),
];

#[cfg(test)]
mod tests {
    use crate::complex::Complex;
    use crate::testing::*;
    use asmotion_value::Value;

    #[test]
    fn sums() {
        check("sum", "Powerset(D)", &[Value::set(ints([3, 1, 3]))], "4");
        check("sum", "Bag(D)", &[Value::bag(ints([3, 1, 3]))], "7");
        check("sum", "Bag(D)", &[Value::bag([1.5, 1.5].map(real))], "3.0");
        check(
            "sum",
            "Powerset(Real)",
            &[Value::set([0.5, 1.5].map(real))],
            "2.0",
        );
        let unit = Complex::new(0.0, 1.0).value();
        check(
            "sum",
            "Bag(D)",
            &[Value::bag([unit.clone(), unit])],
            "0.0+i2.0",
        );
        check(
            "sum",
            "Powerset(D)",
            &[Value::set([int(1), UNDEF])],
            "undef",
        );
        check("sum", "Powerset(D)", &[UNDEF], "undef");
    }

    #[test]
    fn an_empty_sum_is_zero() {
        check("sum", "Powerset(D)", &[Value::set([])], "0");
        check("sum", "Powerset(Real)", &[Value::set([])], "0.0");
        check("sum", "Bag(D)", &[Value::bag([])], "0");
        check("sum", "Bag(Real)", &[Value::bag([])], "0.0");
    }

    #[test]
    fn only_numbers_of_one_domain_add() {
        check(
            "sum",
            "Powerset(D)",
            &[Value::set([int(1), real(1.0)])],
            "`sum` cannot add a Real to an Integer",
        );
        check(
            "sum",
            "Bag(D)",
            &[Value::bag([text("a")])],
            "`sum` cannot add a String to a number",
        );
        check(
            "sum",
            "Bag(D)",
            &[Value::bag([MAX, MAX])],
            "`mult(9223372036854775807, 2)` does not fit into a 64-bit integer",
        );
    }
}
