//! Finite maps. Keys and values may be `undef`; if a map is `undef`, so is the result.

use crate::argument::{binary, ternary};
use crate::builtin::{Builtin, strict, total};
use asmotion_value::Value;
use std::collections::BTreeMap;

/// A finite map from keys to values.
pub type MapValue = BTreeMap<Value, Value>;

/// Returns the value of `key`, or `None` if there is none.
pub fn at<'a>(map: &'a MapValue, key: &Value) -> Option<&'a Value> {
    map.get(key)
}

/// Returns `map` with `value` for `key`, replacing a previous value.
pub fn assign(map: &MapValue, key: &Value, value: &Value) -> MapValue {
    let mut map = map.clone();
    map.insert(key.clone(), value.clone());
    map
}

/// Returns the entries of both maps; for a key in both, `right` prevails.
pub fn merge(left: &MapValue, right: &MapValue) -> MapValue {
    let pairs = left.iter().chain(right);
    pairs
        .map(|(key, value)| (key.clone(), value.clone()))
        .collect()
}

pub(crate) const TABLE: &[Builtin] = &[
    total("at", "Prod(Map(D1,D2),D1)", |arguments, _| {
        binary(arguments, |map: Option<_>, key| {
            map.and_then(|map| at(map, key))
        })
    }),
    total("assign", "Prod(Map(D1,D2),D1,D2)", |arguments, _| {
        ternary(arguments, |map: Option<_>, key, value| {
            map.map(|map| assign(map, key, value))
        })
    }),
    strict("merge", "Prod(Map(D1,D2),Map(D1,D2))", |arguments, _| {
        binary(arguments, merge)
    }),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::*;
    use proptest::prelude::*;

    #[test]
    fn pairs() {
        let map = || Value::map([(int(1), text("a")), (int(2), UNDEF)]);
        let at = |map, key, expected| check("at", "Prod(Map(D1,D2),D1)", &[map, key], expected);
        at(map(), int(1), r#""a""#);
        at(map(), int(2), "undef");
        at(map(), int(3), "undef");
        at(map(), UNDEF, "undef");
        at(UNDEF, int(1), "undef");
        let assign = |map, key, expected| {
            check(
                "assign",
                "Prod(Map(D1,D2),D1,D2)",
                &[map, key, text("b")],
                expected,
            );
        };
        assign(map(), int(1), r#"{1 -> "b", 2 -> undef}"#);
        assign(map(), int(3), r#"{1 -> "a", 2 -> undef, 3 -> "b"}"#);
        assign(UNDEF, int(3), "undef");
        let merge = |left, right, expected| {
            check(
                "merge",
                "Prod(Map(D1,D2),Map(D1,D2))",
                &[left, right],
                expected,
            );
        };
        merge(
            map(),
            Value::map([(int(2), text("c"))]),
            r#"{1 -> "a", 2 -> "c"}"#,
        );
        merge(map(), UNDEF, "undef");
    }

    fn maps() -> impl Strategy<Value = MapValue> {
        let number = || (0_i64..4).prop_map(Value::Int);
        prop::collection::btree_map(number(), number(), 0..4)
    }

    proptest! {
        #[test]
        fn the_right_map_wins(a in maps(), b in maps(), c in maps(), n in 0_i64..4) {
            let n = Value::Int(n);
            let merged = merge(&a, &b);
            prop_assert_eq!(at(&merged, &n), at(&b, &n).or(at(&a, &n)));
            prop_assert_eq!(merge(&a, &merge(&b, &c)), merge(&merge(&a, &b), &c));
            let assigned = assign(&a, &n, &n);
            prop_assert_eq!(at(&assigned, &n), Some(&n));
        }
    }
}
