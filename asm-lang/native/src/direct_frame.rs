//! The memory that a direct rule shares with a step, and its calls to the host.
//!
//! The frame begins like [`NativeFrame`](crate::frame::NativeFrame), so that the same code accesses slots, marks and
//! counters. The host functions change nothing that the frame points to, so no pointer becomes stale. The README of this
//! crate gives the whole safety argument.

#![expect(
    unsafe_code,
    reason = "native code and the machine share memory by pointers"
)]

use crate::frame::{PanicPayload, at, caught};
use asmotion_ir::{DomainId, Origin};
use asmotion_machine::Update;
use asmotion_machine::back_end::{Choosing, DirectResult, DirectStep, Mark};
use asmotion_value::Value;
use std::mem::offset_of;
use std::panic::resume_unwind;

/// Offset of the list for previous values.
pub(crate) const BEFORE: i32 = offset_of!(DirectFrame, before) as i32;

/// The signature of a direct rule. It returns 0 if the update set is complete, 1 if it gave up, and 2 if the update set is
/// complete and a previous value is no scalar.
pub(crate) type DirectEntry = unsafe extern "C" fn(*mut DirectFrame) -> u8;

/// Limit for the number of extended domains that a direct rule enumerates.
pub(crate) const MAX_EXTENTS: usize = 4;

/// The elements of a domain.
#[derive(Clone, Copy)]
#[repr(C)]
struct Extent {
    elements: *const Value,
    count: usize,
}

/// Offset of the table of extents.
pub(crate) const EXTENTS: i32 = offset_of!(DirectFrame, extents) as i32;

/// Returns the offsets in the table of the address and the number of the elements of a domain, by its index.
pub(crate) fn extent_offsets(index: usize) -> [i32; 2] {
    let extent = (index * size_of::<Extent>()) as i32;
    [
        extent + offset_of!(Extent, elements) as i32,
        extent + offset_of!(Extent, count) as i32,
    ]
}

/// The interface to a step, at the offsets in [`at`].
#[repr(C)]
pub(crate) struct DirectFrame {
    slots: *mut Value,
    marks: *mut Mark,
    /// The first update; after a complete evaluation, the end of the last one.
    list: *mut Update,
    counters: *mut u64,
    epoch: u32,
    /// The list for previous values; null if the updates are not applied.
    before: *mut Value,
    /// The elements of the domains that the rule enumerates; null if there are none.
    extents: *const Extent,
    step: *mut DirectStep<'static>,
    /// The panic of a chooser, to be resumed when native code returns.
    panic: Option<PanicPayload>,
}

const _: () = {
    assert!(offset_of!(DirectFrame, slots) as i32 == at::SLOTS);
    assert!(offset_of!(DirectFrame, marks) as i32 == at::MARKS);
    assert!(offset_of!(DirectFrame, list) as i32 == at::LIST);
    assert!(offset_of!(DirectFrame, counters) as i32 == at::COUNTERS);
    assert!(offset_of!(DirectFrame, epoch) as i32 == at::EPOCH);
};

impl DirectFrame {
    /// Runs a direct rule, which adds at most `updates` updates.
    #[inline]
    pub fn enter(
        step: &mut DirectStep<'_>,
        entry: DirectEntry,
        updates: usize,
        domains: &[DomainId],
    ) -> DirectResult {
        if domains.is_empty() {
            Self::enter_with(step, entry, updates, std::ptr::null())
        } else {
            Self::enter_with_extents(step, entry, updates, domains)
        }
    }

    #[inline(never)]
    fn enter_with_extents(
        step: &mut DirectStep<'_>,
        entry: DirectEntry,
        updates: usize,
        domains: &[DomainId],
    ) -> DirectResult {
        let mut extents = [Extent {
            elements: std::ptr::null(),
            count: 0,
        }; MAX_EXTENTS];
        for (extent, domain) in extents.iter_mut().zip(domains) {
            let elements = step.extent(*domain);
            (extent.elements, extent.count) = (elements.as_ptr(), elements.len());
        }
        Self::enter_with(step, entry, updates, extents.as_ptr())
    }

    /// Runs a direct rule that enumerates these domains.
    #[inline(always)]
    fn enter_with(
        step: &mut DirectStep<'_>,
        entry: DirectEntry,
        updates: usize,
        extents: *const Extent,
    ) -> DirectResult {
        if has_room(step, updates) {
            Self::enter_with_room(step, entry, extents)
        } else {
            Self::enter_after_growth(step, entry, updates, extents)
        }
    }

    /// Enlarges the lists first. A function of its own, because the other path then keeps nothing across calls.
    #[cold]
    #[inline(never)]
    fn enter_after_growth(
        step: &mut DirectStep<'_>,
        entry: DirectEntry,
        updates: usize,
        extents: *const Extent,
    ) -> DirectResult {
        if let Some(before) = step.before() {
            before.reserve(updates);
        }
        step.update_lists().updates.reserve(updates);
        Self::enter_with_room(step, entry, extents)
    }

    /// Runs a direct rule; both lists have room for its updates.
    #[inline(always)]
    fn enter_with_room(
        step: &mut DirectStep<'_>,
        entry: DirectEntry,
        extents: *const Extent,
    ) -> DirectResult {
        let slots = step.slots_mut().as_mut_ptr();
        let before = match step.before() {
            Some(before) => before.as_mut_ptr(),
            None => std::ptr::null_mut(),
        };
        let counters = step.counters().as_mut_ptr();
        let lists = step.update_lists();
        let list = lists.updates.as_mut_ptr();
        let (marks, epoch) = (lists.marks.as_mut_ptr(), lists.epoch);
        let mut frame = Self {
            slots,
            marks,
            list,
            counters,
            epoch,
            before,
            extents,
            step: std::ptr::from_mut(step).cast(),
            panic: None,
        };
        // SAFETY: the entry was generated for the program of this step and for this layout of the frame, and its memory
        // lives as long as the rule that called this function. It accesses slots and marks only below the number of slots
        // that the program fixes, counters only below their number, reads elements of domains only below theirs, and writes
        // at most as many updates as `has_room` was asked for, for which the lists, empty at the start of a step, have
        // capacity. No extent changes in a direct step. `step` is not used here until it returns.
        let status = unsafe { entry(&raw mut frame) };
        if let Some(payload) = frame.panic {
            resume_unwind(payload);
        }
        if status == 1 {
            return DirectResult::GaveUp;
        }
        // SAFETY: both pointers are into the allocation of the list, and their distance is a multiple of the size of an
        // update, of which native code has initialised as many.
        unsafe {
            let count = frame.list.offset_from_unsigned(list);
            step.update_lists().updates.set_len(count);
            if let Some(before) = step.before() {
                before.set_len(count);
            }
        }
        if status == 0 {
            DirectResult::Scalars
        } else {
            DirectResult::Values
        }
    }

    /// Asks the chooser; returns `None` after a panic, which must not unwind through native code.
    fn asked<T>(&mut self, ask: impl FnOnce(&mut DirectStep<'static>) -> T) -> Option<T> {
        if self.panic.is_some() {
            return None;
        }
        let step = self.step();
        match caught(|| ask(step)) {
            Ok(answer) => Some(answer),
            Err(payload) => {
                self.panic = Some(payload);
                None
            }
        }
    }

    fn step(&mut self) -> &mut DirectStep<'static> {
        // SAFETY: the pointer stems from the exclusive borrow that `enter` holds and does not use meanwhile. The reference
        // does not outlive the call to the host, during which native code is suspended.
        unsafe { &mut *self.step }
    }
}

/// Returns how the value of a variable with this range is chosen: 0 by index, 1 the first candidate, 2 picked from outside.
pub(crate) extern "C" fn way(frame: &mut DirectFrame, range: u32) -> u8 {
    match frame.asked(|step| step.choosing(Origin(range))) {
        Some(Choosing::ByNumber) => 0,
        Some(Choosing::First) | None => 1,
        Some(Choosing::Picked) => 2,
    }
}

/// Returns the index of the chosen one of `count` candidates.
pub(crate) extern "C" fn choose(frame: &mut DirectFrame, count: u64, origin: u32) -> u64 {
    let chosen = frame.asked(|step| step.choose(count as usize, Origin(origin)) as u64);
    chosen.unwrap_or_default()
}

/// Decides about a variable with this range: returns the index of the chosen one of `count` candidates, or [`PICKED`].
pub(crate) extern "C" fn decide(
    frame: &mut DirectFrame,
    range: u32,
    count: u64,
    origin: u32,
) -> u64 {
    let decided = frame.asked(|step| step.decide(Origin(range), count as usize, Origin(origin)));
    match decided {
        Some(Some(index)) => index as u64,
        Some(None) => PICKED,
        None => 0,
    }
}

/// The answer of [`decide`] if the value was picked from outside.
pub(crate) const PICKED: u64 = u64::MAX;

/// Returns `true` if both lists of a step have room for this many updates.
#[inline(always)]
fn has_room(step: &mut DirectStep<'_>, updates: usize) -> bool {
    let has_room_before = step.before().is_none_or(|it| it.capacity() >= updates);
    has_room_before && step.update_lists().updates.capacity() >= updates
}
