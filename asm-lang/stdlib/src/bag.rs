//! Bags (multisets): elements with their multiplicities, which are greater than 0. An element may
//! be `undef`. If a bag is `undef`, so is the result, except that `contains` is false.

use crate::argument::{binary, unary};
use crate::builtin::{Builtin, strict, total};
use crate::collection::{BagValue, SetValue};
use crate::fault::{BuiltinFault, LIMIT};
use crate::integer;
use asmotion_value::Value;

/// Returns `true` if `bag` contains `element`.
pub fn contains(bag: &BagValue, element: &Value) -> bool {
    bag.contains_key(element)
}

/// Returns the multiplicity of `element`, 0 if it is not in `bag`.
pub fn count(bag: &BagValue, element: &Value) -> i64 {
    integer::of(bag.get(element).copied().unwrap_or(0))
}

/// Returns the union; multiplicities are added.
///
/// # Errors
/// [`BuiltinFault::TooLarge`] if a multiplicity exceeds [`LIMIT`].
pub fn union(left: &BagValue, right: &BagValue) -> Result<BagValue, BuiltinFault> {
    let mut union = left.clone();
    for (element, &times) in right {
        add(&mut union, element, times, "union")?;
    }
    Ok(union)
}

/// Returns the intersection, with the lesser multiplicity of each element.
pub fn intersection(left: &BagValue, right: &BagValue) -> BagValue {
    let both = |(element, &times): (&Value, &usize)| {
        right
            .get(element)
            .map(|&others| (element.clone(), times.min(others)))
    };
    left.iter().filter_map(both).collect()
}

/// Returns `bag` with the multiplicity of `element` increased by 1.
///
/// # Errors
/// [`BuiltinFault::TooLarge`] if the multiplicity exceeds [`LIMIT`].
pub fn including(bag: &BagValue, element: &Value) -> Result<BagValue, BuiltinFault> {
    let mut bag = bag.clone();
    add(&mut bag, element, 1, "including")?;
    Ok(bag)
}

/// Returns `bag` with the multiplicity of `element` decreased by 1.
pub fn excluding(bag: &BagValue, element: &Value) -> BagValue {
    let mut bag = bag.clone();
    match bag.get_mut(element) {
        Some(times) if *times > 1 => *times -= 1,
        Some(_) | None => {
            bag.remove(element);
        }
    }
    bag
}

/// Returns the elements in ascending order, each repeated by its multiplicity.
///
/// # Errors
/// [`BuiltinFault::TooLarge`] for more than [`LIMIT`] elements.
pub fn as_sequence(bag: &BagValue) -> Result<Vec<Value>, BuiltinFault> {
    let size = bag
        .values()
        .fold(0_usize, |size, &times| size.saturating_add(times));
    if size > LIMIT {
        return Err(BuiltinFault::TooLarge {
            function: "asSequence",
            size,
        });
    }
    let repeat = |(element, &times)| std::iter::repeat_n(element, times);
    Ok(bag.iter().flat_map(repeat).cloned().collect())
}

/// Returns the set of the elements.
pub fn as_set(bag: &BagValue) -> SetValue {
    bag.keys().cloned().collect()
}

fn add(
    bag: &mut BagValue,
    element: &Value,
    times: usize,
    function: &'static str,
) -> Result<(), BuiltinFault> {
    let size = bag.get(element).copied().unwrap_or(0).saturating_add(times);
    if size > LIMIT {
        return Err(BuiltinFault::TooLarge { function, size });
    }
    bag.insert(element.clone(), size);
    Ok(())
}

pub(crate) const TABLE: &[Builtin] = &[
    total("contains", "Prod(Bag(D),D)", |arguments, _| {
        binary(arguments, |bag: Option<_>, element| {
            bag.is_some_and(|bag| contains(bag, element))
        })
    }),
    total("count", "Prod(Bag(D),D)", |arguments, _| {
        binary(arguments, |bag: Option<_>, element| {
            bag.map(|bag| count(bag, element))
        })
    }),
    strict("union", "Prod(Bag(D),Bag(D))", |arguments, _| {
        binary(arguments, union)
    }),
    strict("union", "Prod(Bag(D),Powerset(D))", |arguments, _| {
        binary(arguments, |bag, set| union(bag, &of_set(set)))
    }),
    strict("intersection", "Prod(Bag(D),Bag(D))", |arguments, _| {
        binary(arguments, intersection)
    }),
    strict(
        "intersection",
        "Prod(Bag(D),Powerset(D))",
        |arguments, _| binary(arguments, |bag, set| intersection(bag, &of_set(set))),
    ),
    total("including", "Prod(Bag(D),D)", |arguments, _| {
        binary(arguments, |bag: Option<_>, element| {
            bag.map(|bag| including(bag, element))
        })
    }),
    total("excluding", "Prod(Bag(D),D)", |arguments, _| {
        binary(arguments, |bag: Option<_>, element| {
            bag.map(|bag| excluding(bag, element))
        })
    }),
    strict("asSequence", "Bag(D)", |arguments, _| {
        unary(arguments, as_sequence)
    }),
    strict("asSet", "Bag(D)", |arguments, _| unary(arguments, as_set)),
];

/// Each element of a set once.
pub fn of_set(set: &SetValue) -> BagValue {
    set.iter().map(|element| (element.clone(), 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::*;
    use proptest::prelude::*;

    fn bag<const N: usize>(numbers: [i64; N]) -> Value {
        Value::bag(ints(numbers))
    }

    #[test]
    fn questions() {
        for (whole, element, contained, times) in [
            (bag([1, 2, 2]), int(2), "true", "2"),
            (bag([1, 2, 2]), int(3), "false", "0"),
            (Value::bag([UNDEF]), UNDEF, "true", "1"),
            (UNDEF, int(1), "false", "undef"),
        ] {
            let arguments = [whole, element];
            check("contains", "Prod(Bag(D),D)", &arguments, contained);
            check("count", "Prod(Bag(D),D)", &arguments, times);
        }
    }

    #[test]
    fn algebra() {
        let two =
            |name, domain, left, right, expected| check(name, domain, &[left, right], expected);
        two(
            "union",
            "Prod(Bag(D),Bag(D))",
            bag([1, 2]),
            bag([2]),
            "<1, 2, 2>",
        );
        two(
            "union",
            "Prod(Bag(D),Powerset(D))",
            bag([1]),
            Value::set(ints([1])),
            "<1, 1>",
        );
        two(
            "intersection",
            "Prod(Bag(D),Bag(D))",
            bag([1, 2, 2, 2]),
            bag([2, 2, 3]),
            "<2, 2>",
        );
        two(
            "intersection",
            "Prod(Bag(D),Powerset(D))",
            bag([2, 2]),
            Value::set(ints([2])),
            "<2>",
        );
        two("including", "Prod(Bag(D),D)", bag([1]), int(1), "<1, 1>");
        two("excluding", "Prod(Bag(D),D)", bag([1, 1]), int(1), "<1>");
        two("excluding", "Prod(Bag(D),D)", bag([1]), int(1), "<>");
        two("excluding", "Prod(Bag(D),D)", bag([1]), int(2), "<1>");
        two("excluding", "Prod(Bag(D),D)", UNDEF, int(2), "undef");
        check("asSequence", "Bag(D)", &[bag([2, 1, 2])], "[1, 2, 2]");
        check("asSet", "Bag(D)", &[bag([2, 1, 2])], "{1, 2}");
    }

    #[test]
    fn a_bag_cannot_fill_the_memory() {
        let full = BagValue::from([(int(1), LIMIT)]);
        let fault = |function, size| Err(BuiltinFault::TooLarge { function, size });
        assert_eq!(
            including(&full, &int(1)).map(|_| ()),
            fault("including", LIMIT + 1)
        );
        assert_eq!(union(&full, &full).map(|_| ()), fault("union", 2 * LIMIT));
        let fuller = BagValue::from([(int(1), LIMIT), (int(2), 1)]);
        assert_eq!(
            as_sequence(&fuller).map(|_| ()),
            fault("asSequence", LIMIT + 1)
        );
    }

    fn bags() -> impl Strategy<Value = BagValue> {
        prop::collection::btree_map((0_i64..4).prop_map(Value::Int), 1_usize..4, 0..4)
    }

    proptest! {
        #[test]
        fn multiplicities_add_and_meet(a in bags(), b in bags(), n in 0_i64..4) {
            let n = Value::Int(n);
            let both = union(&a, &b).map(|both| count(&both, &n));
            prop_assert_eq!(both, Ok(count(&a, &n) + count(&b, &n)));
            prop_assert_eq!(count(&intersection(&a, &b), &n), count(&a, &n).min(count(&b, &n)));
            prop_assert_eq!(union(&a, &b), union(&b, &a));
            prop_assert_eq!(intersection(&a, &b), intersection(&b, &a));
            prop_assert_eq!(including(&a, &n).map(|more| excluding(&more, &n)), Ok(a.clone()));
            prop_assert!(excluding(&a, &n).values().all(|&times| times > 0));
            prop_assert_eq!(as_sequence(&a).map(|seq| crate::sequence::as_bag(&seq)), Ok(a));
        }
    }
}
