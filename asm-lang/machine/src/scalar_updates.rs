//! Fast path for steps that write only scalars: nothing to drop, and no reference counts.

#![expect(
    unsafe_code,
    reason = "lists are filled and emptied without visiting each element"
)]

use crate::updates::Update;
use asmotion_value::Value;

/// Empties a list without dropping its elements. Leaks whatever they own, so they must be scalars.
#[inline]
pub(crate) fn forget<T>(list: &mut Vec<T>) {
    // SAFETY: 0 does not exceed the capacity, and no element has to be initialised for length 0.
    unsafe { list.set_len(0) }
}

/// Applies updates to the slots and moves the previous values into `before`, which must be empty.
/// Returns `true` if all values are scalars.
#[inline]
pub(crate) fn fire(updates: &[Update], slots: &mut [Value], before: &mut Vec<Value>) -> bool {
    before.reserve(updates.len());
    let room = before.spare_capacity_mut().as_mut_ptr();
    let mut is_plain = true;
    for (index, update) in updates.iter().enumerate() {
        let slot = &mut slots[update.slot as usize];
        // SAFETY: `before` has capacity for as many values as there are updates, so `index` is in
        // bounds.
        let place = unsafe { &mut *room.add(index) };
        if slot.is_scalar() && update.value.is_scalar() {
            // SAFETY: `place` is uninitialised memory and `slot` holds a scalar, so neither
            // overwrites anything that has to be dropped. A scalar owns nothing and may be copied
            // bitwise.
            unsafe {
                std::ptr::copy_nonoverlapping(slot, place.as_mut_ptr(), 1);
                std::ptr::copy_nonoverlapping(&update.value, slot, 1);
            }
        } else {
            is_plain = false;
            place.write(std::mem::replace(slot, update.value.clone()));
        }
    }
    // SAFETY: the loop has initialised one value for each update, within the reserved capacity.
    unsafe { before.set_len(updates.len()) }
    is_plain
}

#[cfg(test)]
mod tests {
    use super::*;
    use asmotion_ir::Origin;

    fn update(slot: u32, value: Value) -> Update {
        Update {
            slot,
            value,
            origin: Origin::default(),
        }
    }

    #[test]
    fn scalars_and_shared_values_change_places() {
        let list = || Value::seq([Value::Int(1), Value::text("a")]);
        let mut slots = vec![Value::Int(1), list(), Value::text("b"), Value::Undef];
        let mut before = Vec::new();
        let plain = [update(3, Value::Bool(true)), update(0, Value::Int(7))];
        assert!(fire(&plain, &mut slots, &mut before));
        assert_eq!(before, [Value::Undef, Value::Int(1)]);
        forget(&mut before);
        let shared = [
            update(0, list()),
            update(1, Value::Int(2)),
            update(2, list()),
        ];
        assert!(!fire(&shared, &mut slots, &mut before));
        assert_eq!(before, [Value::Int(7), list(), Value::text("b")]);
        assert_eq!(slots, [list(), Value::Int(2), list(), Value::Bool(true)]);
    }
}
