//! How large a value may be.

use crate::limits::MAX_ELEMENTS;
use asmotion_value::Value;

/// Values may nest this deep.
const MAX_NESTING: usize = 500;

/// Whether a value nests no deeper and holds no more elements than anything else in a machine; what
/// it shares counts as often as it stands.
pub(crate) fn is_bounded(value: &Value) -> bool {
    let mut room = MAX_ELEMENTS;
    is_within(value, MAX_NESTING, &mut room)
}

/// Whether a value nests no deeper than `depth`, and holds no more than there is room for.
fn is_within(value: &Value, depth: usize, room: &mut u64) -> bool {
    fn all<'a>(items: impl IntoIterator<Item = &'a Value>, depth: usize, room: &mut u64) -> bool {
        depth > 0
            && items.into_iter().all(|item| {
                *room = room.saturating_sub(1);
                *room > 0 && is_within(item, depth - 1, room)
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
        Value::Tuple(items) | Value::Seq(items) => all(items.iter(), depth, room),
        Value::Set(items) => all(items.iter(), depth, room),
        Value::Bag(items) => all(items.keys(), depth, room),
        Value::Map(pairs) => all(pairs.keys(), depth, room) && all(pairs.values(), depth, room),
    }
}
