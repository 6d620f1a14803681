//! Sequences, indexed from 0. An element may be `undef`. If a sequence is `undef`, so is the
//! result, except that `contains` is false.

use crate::argument::{binary, ternary, unary};
use crate::builtin::{Builtin, strict, total};
use crate::collection::BagValue;
use crate::collection::SetValue;
use crate::fault::{BuiltinFault, LIMIT};
use crate::integer;
use asmotion_value::Value;

/// Returns the number of elements.
pub fn length(seq: &[Value]) -> i64 {
    integer::of(seq.len())
}

/// Returns `true` if there are no elements.
pub fn is_empty(seq: &[Value]) -> bool {
    seq.is_empty()
}

/// Returns `true` if `seq` contains `element`.
pub fn contains(seq: &[Value], element: &Value) -> bool {
    seq.contains(element)
}

/// Returns the number of occurrences of `element`.
pub fn count(seq: &[Value], element: &Value) -> i64 {
    integer::of(seq.iter().filter(|each| *each == element).count())
}

/// Returns the position of the first occurrence of `element`, or -1 if there is none.
pub fn index_of(seq: &[Value], element: &Value) -> i64 {
    seq.iter()
        .position(|each| each == element)
        .map_or(-1, integer::of)
}

/// Returns the element at a position.
///
/// # Errors
/// [`BuiltinFault::Position`] unless `0 <= position < length`.
#[inline]
pub fn at(seq: &[Value], position: i64) -> Result<&Value, BuiltinFault> {
    usize::try_from(position)
        .ok()
        .and_then(|index| seq.get(index))
        .ok_or(BuiltinFault::Position {
            function: "at",
            position,
            length: seq.len(),
        })
}

/// Returns the first element.
///
/// # Errors
/// [`BuiltinFault::Empty`] if there are no elements.
pub fn first(seq: &[Value]) -> Result<&Value, BuiltinFault> {
    seq.first().ok_or(BuiltinFault::Empty { function: "first" })
}

/// Returns the last element.
///
/// # Errors
/// [`BuiltinFault::Empty`] if there are no elements.
pub fn last(seq: &[Value]) -> Result<&Value, BuiltinFault> {
    seq.last().ok_or(BuiltinFault::Empty { function: "last" })
}

/// Returns all elements but the first.
///
/// # Errors
/// [`BuiltinFault::Empty`] if there are no elements.
pub fn tail(seq: &[Value]) -> Result<Vec<Value>, BuiltinFault> {
    match seq {
        [] => Err(BuiltinFault::Empty { function: "tail" }),
        [_, tail @ ..] => Ok(tail.to_vec()),
    }
}

/// Returns the elements at positions `from` to `to - 1`.
///
/// # Errors
/// [`BuiltinFault::Part`] unless `0 <= from <= to <= length`.
pub fn sub_sequence(seq: &[Value], from: i64, to: i64) -> Result<Vec<Value>, BuiltinFault> {
    let start = usize::try_from(from).ok();
    let end = usize::try_from(to).ok();
    start
        .zip(end)
        .and_then(|(start, end)| seq.get(start..end))
        .map(<[Value]>::to_vec)
        .ok_or(BuiltinFault::Part {
            function: "subSequence",
            from,
            to,
            length: seq.len(),
        })
}

/// Returns the concatenation of two sequences.
///
/// # Errors
/// [`BuiltinFault::TooLarge`] for more than [`LIMIT`] elements.
pub fn union(left: &[Value], right: &[Value]) -> Result<Vec<Value>, BuiltinFault> {
    let size = left.len().saturating_add(right.len());
    if size > LIMIT {
        return Err(BuiltinFault::TooLarge {
            function: "union",
            size,
        });
    }
    Ok([left, right].concat())
}

/// Returns `seq` with `element` added at the end.
pub fn append(seq: &[Value], element: &Value) -> Vec<Value> {
    [seq, std::slice::from_ref(element)].concat()
}

/// Returns `seq` with `element` added at the front.
pub fn prepend(element: &Value, seq: &[Value]) -> Vec<Value> {
    [std::slice::from_ref(element), seq].concat()
}

/// Returns `seq` with `element` inserted before the one at `position`, or appended if that is the
/// length.
///
/// # Errors
/// [`BuiltinFault::Position`] unless `0 <= position <= length`.
pub fn insert_at(
    seq: &[Value],
    position: i64,
    element: &Value,
) -> Result<Vec<Value>, BuiltinFault> {
    let (before, after) = usize::try_from(position)
        .ok()
        .and_then(|index| seq.split_at_checked(index))
        .ok_or(BuiltinFault::Position {
            function: "insertAt",
            position,
            length: seq.len(),
        })?;
    Ok([before, std::slice::from_ref(element), after].concat())
}

/// Returns `seq` with the element at `position` replaced.
///
/// # Errors
/// [`BuiltinFault::Position`] unless `0 <= position < length`.
pub fn replace_at(
    seq: &[Value],
    position: i64,
    element: &Value,
) -> Result<Vec<Value>, BuiltinFault> {
    let mut seq = seq.to_vec();
    let length = seq.len();
    let place = usize::try_from(position)
        .ok()
        .and_then(|index| seq.get_mut(index))
        .ok_or(BuiltinFault::Position {
            function: "replaceAt",
            position,
            length,
        })?;
    *place = element.clone();
    Ok(seq)
}

/// Returns `seq` without the first occurrence of `element`.
pub fn excluding(seq: &[Value], element: &Value) -> Vec<Value> {
    let mut seq = seq.to_vec();
    if let Some(index) = seq.iter().position(|each| each == element) {
        seq.remove(index);
    }
    seq
}

/// Returns the set of the elements.
pub fn as_set(seq: &[Value]) -> SetValue {
    seq.iter().cloned().collect()
}

/// Returns the bag of the elements, with their numbers of occurrences.
pub fn as_bag(seq: &[Value]) -> BagValue {
    let mut bag = BagValue::new();
    for element in seq {
        *bag.entry(element.clone()).or_insert(0) += 1;
    }
    bag
}

pub(crate) const TABLE: &[Builtin] = &[
    strict("length", "Seq(D)", |arguments, _| unary(arguments, length)),
    strict("isEmpty", "Seq(D)", |arguments, _| {
        unary(arguments, is_empty)
    }),
    total("contains", "Prod(Seq(D),D)", |arguments, _| {
        binary(arguments, |seq: Option<_>, element| {
            seq.is_some_and(|seq| contains(seq, element))
        })
    }),
    total("count", "Prod(Seq(D),D)", |arguments, _| {
        binary(arguments, |seq: Option<_>, element| {
            seq.map(|seq| count(seq, element))
        })
    }),
    total("indexOf", "Prod(Seq(D),D)", |arguments, _| {
        binary(arguments, |seq: Option<_>, element| {
            seq.map(|seq| index_of(seq, element))
        })
    }),
    strict("at", "Prod(Seq(D),Natural)", |arguments, _| {
        binary(arguments, at)
    }),
    strict("first", "Seq(D)", |arguments, _| unary(arguments, first)),
    strict("last", "Seq(D)", |arguments, _| unary(arguments, last)),
    strict("tail", "Seq(D)", |arguments, _| unary(arguments, tail)),
    strict(
        "subSequence",
        "Prod(Seq(D),Natural,Natural)",
        |arguments, _| ternary(arguments, sub_sequence),
    ),
    strict("union", "Prod(Seq(D),Seq(D))", |arguments, _| {
        binary(arguments, union)
    }),
    total("append", "Prod(Seq(D),D)", |arguments, _| {
        binary(arguments, |seq: Option<_>, element| {
            seq.map(|seq| append(seq, element))
        })
    }),
    total("prepend", "Prod(D,Seq(D))", |arguments, _| {
        binary(arguments, |element, seq: Option<_>| {
            seq.map(|seq| prepend(element, seq))
        })
    }),
    total("insertAt", "Prod(Seq(D),Natural,D)", |arguments, _| {
        ternary(arguments, |seq: Option<_>, position: Option<_>, element| {
            seq.zip(position)
                .map(|(seq, position)| insert_at(seq, position, element))
        })
    }),
    total("replaceAt", "Prod(Seq(D),Natural,D)", |arguments, _| {
        ternary(arguments, |seq: Option<_>, position: Option<_>, element| {
            seq.zip(position)
                .map(|(seq, position)| replace_at(seq, position, element))
        })
    }),
    total("excluding", "Prod(Seq(D),D)", |arguments, _| {
        binary(arguments, |seq: Option<_>, element| {
            seq.map(|seq| excluding(seq, element))
        })
    }),
    strict("asSet", "Seq(D)", |arguments, _| unary(arguments, as_set)),
    strict("asBag", "Seq(D)", |arguments, _| unary(arguments, as_bag)),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::*;
    use proptest::prelude::*;

    fn seq<const N: usize>(numbers: [i64; N]) -> Value {
        Value::seq(ints(numbers))
    }

    #[test]
    fn questions() {
        check("length", "Seq(D)", &[seq([1, 1])], "2");
        check("isEmpty", "Seq(D)", &[seq([])], "true");
        check("length", "Seq(D)", &[UNDEF], "undef");
        // sequence, element: contains, count, indexOf
        for (whole, element, results) in [
            (seq([1, 2, 2]), int(2), ["true", "2", "1"]),
            (seq([1, 2, 2]), int(3), ["false", "0", "-1"]),
            (Value::seq([int(1), UNDEF]), UNDEF, ["true", "1", "1"]),
            (UNDEF, int(1), ["false", "undef", "undef"]),
        ] {
            for (name, expected) in ["contains", "count", "indexOf"].into_iter().zip(results) {
                check(
                    name,
                    "Prod(Seq(D),D)",
                    &[whole.clone(), element.clone()],
                    expected,
                );
            }
        }
    }

    #[test]
    fn elements() {
        let at = |position, expected| {
            check(
                "at",
                "Prod(Seq(D),Natural)",
                &[seq([7, 8]), position],
                expected,
            );
        };
        at(int(1), "8");
        at(int(2), "position 2 of `at` is outside a length of 2");
        at(int(-1), "position -1 of `at` is outside a length of 2");
        at(UNDEF, "undef");
        for (name, of_some, of_none) in [
            ("first", "7", "`first` of an empty argument"),
            ("last", "8", "`last` of an empty argument"),
            ("tail", "[8]", "`tail` of an empty argument"),
        ] {
            check(name, "Seq(D)", &[seq([7, 8])], of_some);
            check(name, "Seq(D)", &[seq([])], of_none);
            check(name, "Seq(D)", &[UNDEF], "undef");
        }
        let part = |from, to, expected| {
            let arguments = [seq([1, 2, 3]), int(from), int(to)];
            check(
                "subSequence",
                "Prod(Seq(D),Natural,Natural)",
                &arguments,
                expected,
            );
        };
        part(0, 2, "[1, 2]");
        part(3, 3, "[]");
        part(
            2,
            1,
            "range 2 to 1 of `subSequence` is outside a length of 3",
        );
        part(
            0,
            4,
            "range 0 to 4 of `subSequence` is outside a length of 3",
        );
    }

    #[test]
    fn construction() {
        check(
            "union",
            "Prod(Seq(D),Seq(D))",
            &[seq([1]), seq([1, 2])],
            "[1, 1, 2]",
        );
        check("append", "Prod(Seq(D),D)", &[seq([1]), int(2)], "[1, 2]");
        check("append", "Prod(Seq(D),D)", &[seq([1]), UNDEF], "[1, undef]");
        check("append", "Prod(Seq(D),D)", &[UNDEF, int(2)], "undef");
        check("prepend", "Prod(D,Seq(D))", &[int(2), seq([1])], "[2, 1]");
        check("prepend", "Prod(D,Seq(D))", &[int(2), UNDEF], "undef");
        // position: insertAt, replaceAt
        for (position, results) in [
            (int(0), ["[9, 7, 8]", "[9, 8]"]),
            (int(1), ["[7, 9, 8]", "[7, 9]"]),
            (
                int(2),
                [
                    "[7, 8, 9]",
                    "position 2 of `replaceAt` is outside a length of 2",
                ],
            ),
            (
                int(3),
                [
                    "position 3 of `insertAt` is outside a length of 2",
                    "position 3 of `replaceAt` is outside a length of 2",
                ],
            ),
            (UNDEF, ["undef", "undef"]),
        ] {
            for (name, expected) in ["insertAt", "replaceAt"].into_iter().zip(results) {
                let arguments = [seq([7, 8]), position.clone(), int(9)];
                check(name, "Prod(Seq(D),Natural,D)", &arguments, expected);
            }
        }
        check(
            "excluding",
            "Prod(Seq(D),D)",
            &[seq([1, 2, 1]), int(1)],
            "[2, 1]",
        );
        check("excluding", "Prod(Seq(D),D)", &[seq([1]), int(2)], "[1]");
        check("asSet", "Seq(D)", &[seq([2, 1, 2])], "{1, 2}");
        check("asBag", "Seq(D)", &[seq([2, 1, 2])], "<1, 2, 2>");
    }

    #[test]
    fn a_sequence_cannot_fill_the_memory() {
        let half = vec![Value::Undef; LIMIT / 2 + 1];
        let fault = BuiltinFault::TooLarge {
            function: "union",
            size: LIMIT + 2,
        };
        assert_eq!(union(&half, &half), Err(fault));
    }

    fn seqs() -> impl Strategy<Value = Vec<Value>> {
        prop::collection::vec((0_i64..4).prop_map(Value::Int), 0..8)
    }

    proptest! {
        #[test]
        fn what_is_inserted_is_there(seq in seqs(), position in 0_i64..10, n in 0_i64..4) {
            let n = Value::Int(n);
            match insert_at(&seq, position, &n) {
                Ok(longer) => {
                    prop_assert_eq!(at(&longer, position), Ok(&n));
                    prop_assert_eq!(length(&longer), length(&seq) + 1);
                    let halves = sub_sequence(&longer, 0, position)
                        .and_then(|before| union(&before, &sub_sequence(&longer, position + 1, length(&longer))?));
                    prop_assert_eq!(halves, Ok(seq));
                }
                Err(_) => prop_assert!(position > length(&seq)),
            }
        }

        #[test]
        fn counting_agrees_with_the_bag(seq in seqs(), n in 0_i64..4) {
            let n = Value::Int(n);
            prop_assert_eq!(count(&seq, &n), crate::bag::count(&as_bag(&seq), &n));
            prop_assert_eq!(contains(&seq, &n), count(&seq, &n) > 0);
            prop_assert_eq!(contains(&seq, &n), at(&seq, index_of(&seq, &n)) == Ok(&n));
            prop_assert_eq!(count(&excluding(&seq, &n), &n), (count(&seq, &n) - 1).max(0));
        }
    }
}
