//! The tables of all topics, and the functions in them by name and domain.

use crate::builtin::Builtin;
use crate::{
    any, bag, boolean, character, complex, integer, map, natural, real, sequence, set, sum, text,
    time, tuple,
};
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// The topics, in the order of the library.
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

/// The function with this name and this domain, written as in [`Builtin::domain`].
pub fn builtin(name: &str, domain: &str) -> Option<&'static Builtin> {
    INDEX.get(&(name, domain)).copied()
}

/// The function as `--compat asmeta` wants it: as [`builtin`] has it, except where the reference
/// tool observably computes something else: `difference` is symmetric there, integers wrap around,
/// `iton` lets negative numbers pass, and a set is written as a list.
pub fn compatible(name: &str, domain: &str) -> Option<&'static Builtin> {
    COMPATIBLE
        .get(&(name, domain))
        .copied()
        .or_else(|| builtin(name, domain))
}

/// Every function that has a body, in the order of the library.
pub fn builtins() -> impl Iterator<Item = &'static Builtin> {
    TOPICS.iter().copied().flatten()
}
