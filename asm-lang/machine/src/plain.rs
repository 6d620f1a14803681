//! Steps that write scalars only: there is nothing to drop, and nothing to share.

#![allow(
    unsafe_code,
    reason = "lists are filled and emptied without a look at each element"
)]

use crate::updates::Update;
use value::Value;

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
    let mut is_plain = true;
    for (update, place) in updates.iter().zip(before.spare_capacity_mut()) {
        let slot = &mut slots[update.slot as usize];
        is_plain &= slot.is_scalar();
        let value = match update.value.is_scalar() {
            true => update.value.clone(),
            false => {
                is_plain = false;
                update.value.clone()
            }
        };
        place.write(std::mem::replace(slot, value));
    }
    // SAFETY: there was room for them all, so as many were written.
    unsafe { before.set_len(updates.len()) }
    is_plain
}
