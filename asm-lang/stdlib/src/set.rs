//! Finite sets. An element may be `undef`. If a set is `undef`, so is the result, except that
//! `contains` is false.

use crate::argument::{binary, unary};
use crate::builtin::{Builtin, strict, total};
use crate::collection::{BagValue, SetValue};
use crate::{bag, integer};
use asmotion_value::Value;

/// Returns the number of elements.
pub fn size(set: &SetValue) -> i64 {
    integer::of(set.len())
}

/// Returns `true` if there are no elements.
pub fn is_empty(set: &SetValue) -> bool {
    set.is_empty()
}

/// Returns `true` if `set` contains `element`.
pub fn contains(set: &SetValue, element: &Value) -> bool {
    set.contains(element)
}

/// Returns 1 if `set` contains `element`, otherwise 0.
pub fn count(set: &SetValue, element: &Value) -> i64 {
    i64::from(set.contains(element))
}

/// Returns `true` if `part` is a subset of `whole`. Note the order: the subset comes second.
pub fn all_in(whole: &SetValue, part: &SetValue) -> bool {
    part.is_subset(whole)
}

/// Returns the elements of either set.
pub fn union(left: &SetValue, right: &SetValue) -> SetValue {
    left.union(right).cloned().collect()
}

/// Returns the elements of both sets.
pub fn intersection(left: &SetValue, right: &SetValue) -> SetValue {
    left.intersection(right).cloned().collect()
}

/// Returns the elements of `set` that are also in `bag`.
pub fn intersection_with_bag(set: &SetValue, bag: &BagValue) -> SetValue {
    set.iter()
        .filter(|element| bag.contains_key(element))
        .cloned()
        .collect()
}

/// Returns the elements of `left` that are not in `right`.
pub fn difference(left: &SetValue, right: &SetValue) -> SetValue {
    left.difference(right).cloned().collect()
}

/// Returns the elements of exactly one of the sets.
pub fn symmetric_difference(left: &SetValue, right: &SetValue) -> SetValue {
    left.symmetric_difference(right).cloned().collect()
}

/// Returns `set` with `element` added.
pub fn including(set: &SetValue, element: &Value) -> SetValue {
    let mut set = set.clone();
    set.insert(element.clone());
    set
}

/// Returns `set` without `element`.
pub fn excluding(set: &SetValue, element: &Value) -> SetValue {
    let mut set = set.clone();
    set.remove(element);
    set
}

/// Returns the least element, or `None` for the empty set.
pub fn choose_one(set: &SetValue) -> Option<Value> {
    set.first().cloned()
}

/// Returns the elements in ascending order.
pub fn as_sequence(set: &SetValue) -> Vec<Value> {
    set.iter().cloned().collect()
}

pub(crate) const TABLE: &[Builtin] = &[
    strict("size", "Powerset(D)", |arguments, _| unary(arguments, size)),
    strict("isEmpty", "Powerset(D)", |arguments, _| {
        unary(arguments, is_empty)
    }),
    strict("notEmpty", "Powerset(D)", |arguments, _| {
        unary(arguments, |set| !is_empty(set))
    }),
    total("contains", "Prod(Powerset(D),D)", |arguments, _| {
        binary(arguments, |set: Option<_>, element| {
            set.is_some_and(|set| contains(set, element))
        })
    }),
    total("notin", "Prod(Powerset(D),D)", |arguments, _| {
        binary(arguments, |set: Option<_>, element| {
            !set.is_some_and(|set| contains(set, element))
        })
    }),
    total("count", "Prod(Powerset(D),D)", |arguments, _| {
        binary(arguments, |set: Option<_>, element| {
            set.map(|set| count(set, element))
        })
    }),
    strict("allin", "Prod(Powerset(D),Powerset(D))", |arguments, _| {
        binary(arguments, all_in)
    }),
    strict(
        "notallin",
        "Prod(Powerset(D),Powerset(D))",
        |arguments, _| binary(arguments, |whole, part| !all_in(whole, part)),
    ),
    strict(
        "equality",
        "Prod(Powerset(D),Powerset(D))",
        |arguments, _| binary(arguments, |left: &SetValue, right: &SetValue| left == right),
    ),
    strict("union", "Prod(Powerset(D),Powerset(D))", |arguments, _| {
        binary(arguments, union)
    }),
    strict("union", "Prod(Powerset(D),Powerset(D1))", |arguments, _| {
        binary(arguments, union)
    }),
    strict("union", "Prod(Powerset(D),Bag(D))", |arguments, _| {
        binary(arguments, |set, bag| bag::union(bag, &bag::of_set(set)))
    }),
    strict(
        "intersection",
        "Prod(Powerset(D),Powerset(D))",
        |arguments, _| binary(arguments, intersection),
    ),
    strict(
        "intersection",
        "Prod(Powerset(D),Bag(D))",
        |arguments, _| binary(arguments, intersection_with_bag),
    ),
    strict(
        "difference",
        "Prod(Powerset(D),Powerset(D))",
        |arguments, _| binary(arguments, difference),
    ),
    strict(
        "symmetricDifference",
        "Prod(Powerset(D),Powerset(D))",
        |arguments, _| binary(arguments, symmetric_difference),
    ),
    total("including", "Prod(Powerset(D),D)", |arguments, _| {
        binary(arguments, |set: Option<_>, element| {
            set.map(|set| including(set, element))
        })
    }),
    total("excluding", "Prod(Powerset(D),D)", |arguments, _| {
        binary(arguments, |set: Option<_>, element| {
            set.map(|set| excluding(set, element))
        })
    }),
    strict("chooseone", "Powerset(D)", |arguments, _| {
        unary(arguments, choose_one)
    }),
    strict("asSequence", "Powerset(D)", |arguments, _| {
        unary(arguments, as_sequence)
    }),
    strict("asBag", "Powerset(D)", |arguments, _| {
        unary(arguments, bag::of_set)
    }),
];

/// Functions that differ in the reference tools: `difference` is symmetric.
pub(crate) const COMPATIBLE: &[Builtin] = &[strict(
    "difference",
    "Prod(Powerset(D),Powerset(D))",
    |arguments, _| binary(arguments, symmetric_difference),
)];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::*;
    use proptest::prelude::*;

    fn set<const N: usize>(numbers: [i64; N]) -> Value {
        Value::set(ints(numbers))
    }

    #[test]
    fn questions() {
        check("size", "Powerset(D)", &[set([3, 1, 3])], "2");
        check("isEmpty", "Powerset(D)", &[set([])], "true");
        check("notEmpty", "Powerset(D)", &[set([])], "false");
        check("isEmpty", "Powerset(D)", &[UNDEF], "undef");
        check("chooseone", "Powerset(D)", &[set([3, 1, 2])], "1");
        check("chooseone", "Powerset(D)", &[set([])], "undef");
        // set, element: contains, notin, count
        for (whole, element, results) in [
            (set([1, 2]), int(2), ["true", "false", "1"]),
            (set([1, 2]), int(3), ["false", "true", "0"]),
            (set([1, 2]), UNDEF, ["false", "true", "0"]),
            (Value::set([UNDEF]), UNDEF, ["true", "false", "1"]),
            (UNDEF, int(1), ["false", "true", "undef"]),
        ] {
            for (name, expected) in ["contains", "notin", "count"].into_iter().zip(results) {
                let arguments = [whole.clone(), element.clone()];
                check(name, "Prod(Powerset(D),D)", &arguments, expected);
            }
        }
        for (whole, part, all, equal) in [
            (set([1, 2]), set([1]), "true", "false"),
            (set([1]), set([1, 2]), "false", "false"),
            (set([1, 2]), set([2, 1]), "true", "true"),
            (set([1]), set([]), "true", "false"),
            (UNDEF, set([]), "undef", "undef"),
        ] {
            let arguments = [whole, part];
            check("allin", "Prod(Powerset(D),Powerset(D))", &arguments, all);
            check(
                "equality",
                "Prod(Powerset(D),Powerset(D))",
                &arguments,
                equal,
            );
        }
        check(
            "notallin",
            "Prod(Powerset(D),Powerset(D))",
            &[set([1]), set([2])],
            "true",
        );
    }

    #[test]
    fn algebra() {
        let two =
            |name, domain, left, right, expected| check(name, domain, &[left, right], expected);
        let sets = "Prod(Powerset(D),Powerset(D))";
        two("union", sets, set([1, 2]), set([2, 3]), "{1, 2, 3}");
        two(
            "union",
            "Prod(Powerset(D),Powerset(D1))",
            set([1]),
            Value::set([TRUE]),
            "{true, 1}",
        );
        two(
            "union",
            "Prod(Powerset(D),Bag(D))",
            set([1]),
            Value::bag(ints([1, 2])),
            "<1, 1, 2>",
        );
        two("intersection", sets, set([1, 2]), set([2, 3]), "{2}");
        two(
            "intersection",
            "Prod(Powerset(D),Bag(D))",
            set([1, 2]),
            Value::bag(ints([2, 2])),
            "{2}",
        );
        two("difference", sets, set([1, 2]), set([2, 3]), "{1}");
        two(
            "symmetricDifference",
            sets,
            set([1, 2]),
            set([2, 3]),
            "{1, 3}",
        );
        two("union", sets, set([1]), UNDEF, "undef");
        let one = "Prod(Powerset(D),D)";
        two("including", one, set([1]), int(2), "{1, 2}");
        two("including", one, set([1]), UNDEF, "{undef, 1}");
        two("including", one, UNDEF, int(1), "undef");
        two("excluding", one, set([1, 2]), int(2), "{1}");
        two("excluding", one, set([1]), int(2), "{1}");
        check("asSequence", "Powerset(D)", &[set([3, 1, 2])], "[1, 2, 3]");
        check("asBag", "Powerset(D)", &[set([3, 1, 2])], "<1, 2, 3>");
    }

    #[test]
    fn the_reference_has_another_difference() {
        let sets = "Prod(Powerset(D),Powerset(D))";
        let arguments = [set([1, 2]), set([2, 3])];
        check("difference", sets, &arguments, "{1}");
        check_compatible("difference", sets, &arguments, "{1, 3}");
        check_compatible("union", sets, &arguments, "{1, 2, 3}");
    }

    fn sets() -> impl Strategy<Value = SetValue> {
        prop::collection::btree_set((0_i64..8).prop_map(Value::Int), 0..8)
    }

    proptest! {
        #[test]
        fn sets_are_a_boolean_algebra(a in sets(), b in sets(), c in sets()) {
            prop_assert_eq!(union(&a, &b), union(&b, &a));
            prop_assert_eq!(intersection(&a, &b), intersection(&b, &a));
            prop_assert_eq!(union(&a, &intersection(&a, &b)), a.clone());
            prop_assert_eq!(
                intersection(&a, &union(&b, &c)),
                union(&intersection(&a, &b), &intersection(&a, &c))
            );
            prop_assert_eq!(difference(&a, &union(&b, &c)), difference(&difference(&a, &b), &c));
            prop_assert_eq!(
                symmetric_difference(&a, &b),
                union(&difference(&a, &b), &difference(&b, &a))
            );
            prop_assert_eq!(all_in(&a, &b), union(&a, &b) == a);
            prop_assert_eq!(union(&difference(&a, &b), &intersection(&a, &b)), a);
        }

        #[test]
        fn including_and_excluding_undo_each_other(a in sets(), n in 0_i64..8) {
            let n = Value::Int(n);
            prop_assert!(contains(&including(&a, &n), &n));
            prop_assert_eq!(excluding(&including(&a, &n), &n), excluding(&a, &n));
            prop_assert_eq!(size(&including(&a, &n)), size(&a) + i64::from(!contains(&a, &n)));
            prop_assert_eq!(crate::sequence::as_set(&as_sequence(&a)), a.clone());
            prop_assert!(choose_one(&a).is_none_or(|one| a.iter().all(|each| one <= *each)));
        }
    }
}
