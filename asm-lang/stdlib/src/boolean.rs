//! Truth values in Kleene's strong three-valued logic; `None` is `undef`, read as unknown.

use crate::argument::{binary, unary};
use crate::builtin::{Builtin, total};

/// A truth value, or `None` for `undef`.
pub type TruthValue = Option<bool>;

/// Negation; `undef` for `undef`.
#[inline]
pub fn not(operand: TruthValue) -> TruthValue {
    operand.map(|truth| !truth)
}

/// Conjunction; `false` if either operand is `false`.
#[inline]
pub fn and(left: TruthValue, right: TruthValue) -> TruthValue {
    match (left, right) {
        (Some(false), _) | (_, Some(false)) => Some(false),
        (Some(true), Some(true)) => Some(true),
        (None, Some(true) | None) | (Some(true), None) => None,
    }
}

/// Disjunction; `true` if either operand is `true`.
#[inline]
pub fn or(left: TruthValue, right: TruthValue) -> TruthValue {
    not(and(not(left), not(right)))
}

/// Exclusive disjunction; `undef` if either operand is.
#[inline]
pub fn xor(left: TruthValue, right: TruthValue) -> TruthValue {
    Some(left? != right?)
}

/// Implication; `true` if the premise is `false` or the conclusion `true`.
#[inline]
pub fn implies(left: TruthValue, right: TruthValue) -> TruthValue {
    or(not(left), right)
}

/// Equivalence; `undef` if either operand is.
#[inline]
pub fn iff(left: TruthValue, right: TruthValue) -> TruthValue {
    Some(left? == right?)
}

pub(crate) const TABLE: &[Builtin] = &[
    total("not", "Boolean", |arguments, _| unary(arguments, not)),
    total("and", "Prod(Boolean,Boolean)", |arguments, _| {
        binary(arguments, and)
    }),
    total("or", "Prod(Boolean,Boolean)", |arguments, _| {
        binary(arguments, or)
    }),
    total("xor", "Prod(Boolean,Boolean)", |arguments, _| {
        binary(arguments, xor)
    }),
    total("implies", "Prod(Boolean,Boolean)", |arguments, _| {
        binary(arguments, implies)
    }),
    total("iff", "Prod(Boolean,Boolean)", |arguments, _| {
        binary(arguments, iff)
    }),
    total("iif", "Prod(Boolean,Boolean)", |arguments, _| {
        binary(arguments, iff)
    }),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::*;

    #[test]
    fn kleene_tables() {
        // both operands, then and, or, xor, implies, iff
        let tables = [
            (TRUE, TRUE, "true true false true true"),
            (TRUE, FALSE, "false true true false false"),
            (TRUE, UNDEF, "undef true undef undef undef"),
            (FALSE, TRUE, "false true true true false"),
            (FALSE, FALSE, "false false false true true"),
            (FALSE, UNDEF, "false undef undef true undef"),
            (UNDEF, TRUE, "undef true undef true undef"),
            (UNDEF, FALSE, "false undef undef undef undef"),
            (UNDEF, UNDEF, "undef undef undef undef undef"),
        ];
        for (left, right, results) in tables {
            let names = ["and", "or", "xor", "implies", "iff"];
            for (name, expected) in names.into_iter().zip(results.split(' ')) {
                check(
                    name,
                    "Prod(Boolean,Boolean)",
                    &[left.clone(), right.clone()],
                    expected,
                );
            }
        }
        check("iif", "Prod(Boolean,Boolean)", &[FALSE, FALSE], "true");
        check("not", "Boolean", &[TRUE], "false");
        check("not", "Boolean", &[FALSE], "true");
        check("not", "Boolean", &[UNDEF], "undef");
    }

    #[test]
    fn laws_hold_with_unknowns() {
        let all = [Some(true), Some(false), None];
        for a in all {
            assert_eq!(not(not(a)), a);
            for b in all {
                assert_eq!(and(a, b), and(b, a));
                assert_eq!(not(and(a, b)), or(not(a), not(b)));
                assert_eq!(xor(a, b), not(iff(a, b)));
                assert_eq!(iff(a, b), and(implies(a, b), implies(b, a)));
            }
        }
    }

    #[test]
    fn another_shape_is_a_fault() {
        check(
            "and",
            "Prod(Boolean,Boolean)",
            &[TRUE, int(1)],
            "expected a Boolean, found an Integer",
        );
        check(
            "not",
            "Boolean",
            &[],
            "expected one argument, found a different number",
        );
    }
}
