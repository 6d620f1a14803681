//! The Rust types of sets and bags.

use asmotion_value::Value;
use std::collections::{BTreeMap, BTreeSet};

/// A finite set of values.
pub type SetValue = BTreeSet<Value>;

/// A bag: elements with their multiplicities.
pub type BagValue = BTreeMap<Value, usize>;
