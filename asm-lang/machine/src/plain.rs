//! Steps that write scalars only: there is nothing to drop, and nothing to share.

#![allow(
    unsafe_code,
    reason = "lists are filled and emptied without a look at each element"
)]

use crate::updates::Update;
use asmotion_value::Value;

/// Empties a list without dropping what is in it: for lists that own nothing.
#[inline]
pub(crate) fn forget<T>(list: &mut Vec<T>) {
    // SAFETY: no element is within a length of 0.
    unsafe { list.set_len(0) }
}

/// Applies updates to the slots and puts what these held before into `before`, which is empty. Gives
/// whether all values are scalars.
#[inline]
pub(crate) fn fire(updates: &[Update], slots: &mut [Value], before: &mut Vec<Value>) -> bool {
    before.reserve(updates.len());
    let room = before.spare_capacity_mut().as_mut_ptr();
    let mut is_plain = true;
    for (index, update) in updates.iter().enumerate() {
        let slot = &mut slots[update.slot as usize];
        // SAFETY: there is room for as many values as there are updates.
        let place = unsafe { &mut *room.add(index) };
        if slot.is_scalar() && update.value.is_scalar() {
            // SAFETY: the place takes what the slot held, which is written over without a drop, and a
            // scalar may be copied: it owns nothing.
            unsafe {
                std::ptr::copy_nonoverlapping(slot, place.as_mut_ptr(), 1);
                std::ptr::copy_nonoverlapping(&update.value, slot, 1);
            }
        } else {
            is_plain = false;
            place.write(std::mem::replace(slot, update.value.clone()));
        }
    }
    // SAFETY: there was room for them all, so as many were written.
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
