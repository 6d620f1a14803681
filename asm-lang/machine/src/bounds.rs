//! Bounds on the size of values.

use crate::limits::MAX_ELEMENTS;
use asmotion_value::Value;

/// Limit for the nesting of a value.
const MAX_NESTING: usize = 500;

/// Returns `true` if a value respects the limits for nesting and for the number of elements. A
/// shared part counts once for each occurrence.
pub(crate) fn is_bounded(value: &Value) -> bool {
    let mut room = MAX_ELEMENTS;
    is_within(value, MAX_NESTING, &mut room)
}

/// Checks a value against a remaining depth and a remaining number of elements, which it reduces.
fn is_within(value: &Value, depth: usize, remaining: &mut u64) -> bool {
    fn all<'a>(
        items: impl IntoIterator<Item = &'a Value>,
        depth: usize,
        remaining: &mut u64,
    ) -> bool {
        depth > 0
            && items.into_iter().all(|item| {
                *remaining = remaining.saturating_sub(1);
                *remaining > 0 && is_within(item, depth - 1, remaining)
            })
    }
    match value {
        Value::Undef
        | Value::Bool(_)
        | Value::Int(_)
        | Value::Real(_)
        | Value::Char(_)
        | Value::Atom(_)
        | Value::Rule(_)
        | Value::Text(_)
        | Value::Complex(_) => true,
        Value::Tuple(items) | Value::Seq(items) => all(items.iter(), depth, remaining),
        Value::Set(items) => all(items.iter(), depth, remaining),
        Value::Bag(items) => all(items.keys(), depth, remaining),
        Value::Map(pairs) => {
            all(pairs.keys(), depth, remaining) && all(pairs.values(), depth, remaining)
        }
    }
}
