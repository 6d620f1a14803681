//! Naturals: 64-bit integers that static types restrict to non-negative values.

use crate::argument::{binary, unary};
use crate::builtin::{Builtin, strict};
use crate::fault::{BuiltinFault, LIMIT};
use crate::to_string::TO_STRING;
use asmotion_value::Value;
use std::collections::BTreeSet;

pub use crate::integer::{
    abs, div, ge, gt, idiv, le, lt, max, min, minus, modulo, mult, plus, to_real,
};

/// Converts to an integer.
#[inline]
pub fn to_integer(operand: i64) -> i64 {
    operand
}

/// Returns the numbers from `from` up to, but excluding, `to`; none if `from >= to`.
///
/// # Errors
/// [`BuiltinFault::TooLarge`] for more than [`LIMIT`] numbers.
pub fn range(from: i64, to: i64) -> Result<BTreeSet<Value>, BuiltinFault> {
    if from >= to {
        return Ok(BTreeSet::new());
    }
    let size = usize::try_from(from.abs_diff(to)).unwrap_or(usize::MAX);
    if size > LIMIT {
        return Err(BuiltinFault::TooLarge {
            function: "range",
            size,
        });
    }
    Ok((from..to).map(Value::Int).collect())
}

pub(crate) const TABLE: &[Builtin] = &[
    strict("plus", "Prod(Natural,Natural)", |arguments, _| {
        binary(arguments, plus)
    }),
    strict("minus", "Prod(Natural,Natural)", |arguments, _| {
        binary(arguments, minus)
    }),
    strict("mult", "Prod(Natural,Natural)", |arguments, _| {
        binary(arguments, mult)
    }),
    strict("div", "Prod(Natural,Natural)", |arguments, _| {
        binary(arguments, div)
    }),
    strict("idiv", "Prod(Natural,Natural)", |arguments, _| {
        binary(arguments, idiv)
    }),
    strict("mod", "Prod(Natural,Natural)", |arguments, _| {
        binary(arguments, modulo)
    }),
    strict("abs", "Natural", |arguments, _| unary(arguments, abs)),
    strict("max", "Prod(Natural,Natural)", |arguments, _| {
        binary(arguments, max)
    }),
    strict("min", "Prod(Natural,Natural)", |arguments, _| {
        binary(arguments, min)
    }),
    strict("lt", "Prod(Natural,Natural)", |arguments, _| {
        binary(arguments, lt)
    }),
    strict("le", "Prod(Natural,Natural)", |arguments, _| {
        binary(arguments, le)
    }),
    strict("gt", "Prod(Natural,Natural)", |arguments, _| {
        binary(arguments, gt)
    }),
    strict("ge", "Prod(Natural,Natural)", |arguments, _| {
        binary(arguments, ge)
    }),
    strict("toString", "Natural", TO_STRING),
    strict("range", "Prod(Natural,Natural)", |arguments, _| {
        binary(arguments, range)
    }),
    strict("ntoi", "Natural", |arguments, _| {
        unary(arguments, to_integer)
    }),
    strict("ntor", "Natural", |arguments, _| unary(arguments, to_real)),
    strict("iton", "Natural", |arguments, _| {
        unary(arguments, to_integer)
    }),
];

#[cfg(test)]
mod tests {
    use crate::testing::*;

    #[test]
    fn arithmetic() {
        let two = |name, left, right, expected| {
            check(
                name,
                "Prod(Natural,Natural)",
                &[int(left), int(right)],
                expected,
            );
        };
        two("plus", 2, 3, "5");
        two("minus", 2, 3, "-1");
        two("mult", 2, 3, "6");
        two("div", 1, 4, "0.25");
        two("idiv", 7, 2, "3");
        two("idiv", 7, 0, "`idiv(7, 0)` divides by zero");
        two("mod", 7, 2, "1");
        two("mod", 7, 0, "`mod(7, 0)` divides by zero");
        two("max", 1, 2, "2");
        two("min", 1, 2, "1");
        two("lt", 1, 2, "true");
        two("le", 2, 2, "true");
        two("gt", 1, 2, "false");
        two("ge", 1, 2, "false");
        check(
            "plus",
            "Prod(Natural,Natural)",
            &[MAX, MAX],
            "`plus(9223372036854775807, 9223372036854775807)` does not fit into a 64-bit integer",
        );
        check("abs", "Natural", &[int(3)], "3");
        check("ntoi", "Natural", &[int(3)], "3");
        check("ntor", "Natural", &[int(3)], "3.0");
        check("iton", "Natural", &[int(3)], "3");
    }

    #[test]
    fn a_range_is_a_set_without_its_end() {
        let range =
            |from, to, expected| check("range", "Prod(Natural,Natural)", &[from, to], expected);
        range(int(1), int(4), "{1, 2, 3}");
        range(int(4), int(4), "{}");
        range(int(4), int(1), "{}");
        range(int(4), UNDEF, "undef");
        range(
            int(0),
            MAX,
            "`range` would create 9223372036854775807 elements, more than 16777216",
        );
    }
}
