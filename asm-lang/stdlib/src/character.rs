//! Characters, ordered by code point.

use crate::argument::binary;
use crate::builtin::{Builtin, strict};
use crate::to_string::TO_STRING;

/// Returns `true` if `left` has the lesser code point.
#[inline]
pub fn lt(left: char, right: char) -> bool {
    left < right
}

/// Returns `true` if `left` has the lesser code point, or the same.
#[inline]
pub fn le(left: char, right: char) -> bool {
    left <= right
}

/// Returns `true` if `left` has the greater code point.
#[inline]
pub fn gt(left: char, right: char) -> bool {
    left > right
}

/// Returns `true` if `left` has the greater code point, or the same.
#[inline]
pub fn ge(left: char, right: char) -> bool {
    left >= right
}

pub(crate) const TABLE: &[Builtin] = &[
    strict("lt", "Prod(Char,Char)", |arguments, _| {
        binary(arguments, lt)
    }),
    strict("le", "Prod(Char,Char)", |arguments, _| {
        binary(arguments, le)
    }),
    strict("gt", "Prod(Char,Char)", |arguments, _| {
        binary(arguments, gt)
    }),
    strict("ge", "Prod(Char,Char)", |arguments, _| {
        binary(arguments, ge)
    }),
    strict("toString", "Char", TO_STRING),
];

#[cfg(test)]
mod tests {
    use crate::testing::*;
    use asmotion_value::Value;

    #[test]
    fn comparison_is_by_code_point() {
        for (left, results) in [
            ('A', "true true false false"),
            ('a', "false true false true"),
            ('é', "false false true true"),
        ] {
            for (name, expected) in ["lt", "le", "gt", "ge"].into_iter().zip(results.split(' ')) {
                check(
                    name,
                    "Prod(Char,Char)",
                    &[Value::Char(left), Value::Char('a')],
                    expected,
                );
            }
        }
        check("toString", "Char", &[Value::Char('é')], r#""é""#);
    }
}
