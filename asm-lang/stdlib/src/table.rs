//! The table of all standard functions, indexed by name and domain.

use crate::builtin::Builtin;
use crate::{
    any, bag, boolean, character, complex, integer, map, natural, real, sequence, set, sum, text,
    time, tuple,
};
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// The functions by topic, in the order of the library.
const TOPICS: &[&[Builtin]] = &[
    any::TABLE,
    boolean::TABLE,
    integer::TABLE,
    natural::TABLE,
    real::TABLE,
    complex::TABLE,
    character::TABLE,
    text::TABLE,
    set::TABLE,
    sequence::TABLE,
    bag::TABLE,
    map::TABLE,
    sum::TABLE,
    tuple::TABLE,
    time::TABLE,
];

type BuiltinIndex = BTreeMap<(&'static str, &'static str), &'static Builtin>;

static INDEX: LazyLock<BuiltinIndex> = LazyLock::new(|| index(builtins()));
static COMPATIBLE: LazyLock<BuiltinIndex> = LazyLock::new(|| {
    let topics = [
        set::COMPATIBLE,
        integer::COMPATIBLE,
        real::COMPATIBLE,
        any::COMPATIBLE,
    ];
    index(topics.into_iter().flatten())
});

fn index(functions: impl Iterator<Item = &'static Builtin>) -> BuiltinIndex {
    functions
        .map(|function| ((function.name, function.domain), function))
        .collect()
}

/// Returns the function with a name and a domain, written as in [`Builtin::domain`].
pub fn builtin(name: &str, domain: &str) -> Option<&'static Builtin> {
    INDEX.get(&(name, domain)).copied()
}

/// Returns the function for `--compat asmeta`. It differs from [`builtin`] where the results of the
/// reference tools observably differ: `difference` is symmetric, integers wrap around, `iton`
/// accepts negative numbers, and sets are written as lists.
pub fn compatible(name: &str, domain: &str) -> Option<&'static Builtin> {
    COMPATIBLE
        .get(&(name, domain))
        .copied()
        .or_else(|| builtin(name, domain))
}

/// Iterates over all functions with a body, in the order of the library.
pub fn builtins() -> impl Iterator<Item = &'static Builtin> {
    TOPICS.iter().copied().flatten()
}
