//! The memory that native code shares with a step, and its calls to the host.
//!
//! Native code gets a single pointer, to a [`NativeFrame`], which contains the raw parts of the
//! vectors that it accesses and a pointer to the step context. For everything else it calls one of
//! the functions in [`out`]. Before each call the lengths of the vectors are set according to the
//! work of native code (`set_lengths`); after each call the frame is updated, because the vectors may
//! have been reallocated (`refresh`). The README of this crate gives the whole safety argument.

#![expect(
    unsafe_code,
    reason = "native code and the machine share memory by pointers"
)]

use crate::detour::Detour;
use asmotion_ir::Origin;
use asmotion_machine::back_end::{
    Choosing, CoveredMark, KleeneTruth, Mark, RuleStopped, SavedValue, StepContext, UpdateLists,
    on_enough_stack,
};
use asmotion_machine::{FaultKind, Update};
use asmotion_value::{Atom, Value};
use std::any::Any;
use std::mem::{ManuallyDrop, offset_of};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

/// The value that a panic carries.
pub(crate) type PanicPayload = Box<dyn Any + Send>;

/// The signature of a native function. It returns 0 if the rule succeeded and 1 if it stopped.
pub(crate) type NativeEntry = unsafe extern "C" fn(*mut NativeFrame) -> u8;

/// The interface to a step, at offsets known to native code (see [`at`]).
#[repr(C)]
pub(crate) struct NativeFrame {
    slots: *mut Value,
    marks: *mut Mark,
    list: *mut Update,
    /// Coverage counters; all are allocated on entry, so they stay in place.
    counters: *mut u64,
    epoch: u32,
    /// Nesting depth of calls on entry.
    depth: u32,
    /// Number of updates in `list`.
    length: usize,
    /// Capacity of `list`.
    room: usize,
    held: *mut SavedValue,
    /// Number of values in `held`, saved from before the sequence.
    held_length: usize,
    covered: *mut CoveredMark,
    /// Number of marks in `covered`, overwritten by inner sets.
    covered_length: usize,
    /// Number of further updates within a sequence for which all three lists have capacity.
    sequence_room: usize,
    locals: *mut Value,
    /// Value of a term evaluated by a closure.
    answer: Value,
    /// Argument of host functions that write a scalar.
    given: ManuallyDrop<Value>,
    run: *mut StepContext<'static>,
    detours: *const Detour,
    /// Number of locals required by closures.
    needed: usize,
    /// The panic of a host function, to be resumed when native code returns.
    panic: Option<PanicPayload>,
}

/// Offsets and sizes for generated code.
pub(crate) mod at {
    use super::{CoveredMark, Mark, NativeFrame, SavedValue, StepContext, Update, offset_of};

    pub const SLOTS: i32 = offset_of!(NativeFrame, slots) as i32;
    pub const MARKS: i32 = offset_of!(NativeFrame, marks) as i32;
    pub const LIST: i32 = offset_of!(NativeFrame, list) as i32;
    pub const LENGTH: i32 = offset_of!(NativeFrame, length) as i32;
    pub const ROOM: i32 = offset_of!(NativeFrame, room) as i32;
    pub const HELD: i32 = offset_of!(NativeFrame, held) as i32;
    pub const HELD_LENGTH: i32 = offset_of!(NativeFrame, held_length) as i32;
    pub const COVERED: i32 = offset_of!(NativeFrame, covered) as i32;
    pub const COVERED_LENGTH: i32 = offset_of!(NativeFrame, covered_length) as i32;
    pub const SEQUENCE_ROOM: i32 = offset_of!(NativeFrame, sequence_room) as i32;
    pub const LOCALS: i32 = offset_of!(NativeFrame, locals) as i32;
    pub const COUNTERS: i32 = offset_of!(NativeFrame, counters) as i32;
    pub const ANSWER: i32 = offset_of!(NativeFrame, answer) as i32;
    pub const GIVEN: i32 = offset_of!(NativeFrame, given) as i32;
    pub const EPOCH: i32 = offset_of!(NativeFrame, epoch) as i32;
    pub const RUN: i32 = offset_of!(NativeFrame, run) as i32;

    pub const AGENT: i32 = offset_of!(StepContext<'static>, agent) as i32;
    pub const CALLS: i32 = offset_of!(StepContext<'static>, calls) as i32;
    pub const BINDINGS: i32 = offset_of!(StepContext<'static>, bindings) as i32;
    pub const ITERATIONS: i32 = offset_of!(StepContext<'static>, iterations) as i32;

    pub const MARK_EPOCH: i32 = offset_of!(Mark, epoch) as i32;
    pub const MARK_INDEX: i32 = offset_of!(Mark, index) as i32;
    pub const MARK_SIZE: i64 = size_of::<Mark>() as i64;

    pub const UPDATE_SLOT: i32 = offset_of!(Update, slot) as i32;
    pub const UPDATE_VALUE: i32 = offset_of!(Update, value) as i32;
    pub const UPDATE_ORIGIN: i32 = offset_of!(Update, origin) as i32;
    pub const UPDATE_SIZE: i64 = size_of::<Update>() as i64;

    pub const HELD_SLOT: i32 = offset_of!(SavedValue, slot) as i32;
    pub const HELD_VALUE: i32 = offset_of!(SavedValue, value) as i32;
    pub const HELD_SIZE: i64 = size_of::<SavedValue>() as i64;

    pub const COVERED_SLOT: i32 = offset_of!(CoveredMark, slot) as i32;
    pub const COVERED_EPOCH: i32 = (offset_of!(CoveredMark, mark) + offset_of!(Mark, epoch)) as i32;
    pub const COVERED_INDEX: i32 = (offset_of!(CoveredMark, mark) + offset_of!(Mark, index)) as i32;
    pub const COVERED_SIZE: i64 = size_of::<CoveredMark>() as i64;

    pub const VALUE_SIZE: i64 = size_of::<asmotion_value::Value>() as i64;
    pub const PAYLOAD: i32 = asmotion_value::layout::PAYLOAD as i32;
}

impl NativeFrame {
    /// Runs native code in the context of a step.
    #[inline]
    pub fn enter(
        run: &mut StepContext<'_>,
        entry: NativeEntry,
        detours: &[Detour],
        needed: usize,
    ) -> Result<(), RuleStopped> {
        let mut frame = Self {
            slots: std::ptr::null_mut(),
            marks: std::ptr::null_mut(),
            list: std::ptr::null_mut(),
            length: 0,
            room: 0,
            held: std::ptr::null_mut(),
            held_length: 0,
            covered: std::ptr::null_mut(),
            covered_length: 0,
            sequence_room: 0,
            locals: std::ptr::null_mut(),
            counters: run.counters().as_mut_ptr(),
            answer: Value::Undef,
            given: ManuallyDrop::new(Value::Undef),
            epoch: 0,
            depth: run.depth,
            run: std::ptr::from_mut(run).cast(),
            detours: detours.as_ptr(),
            needed,
            panic: None,
        };
        frame.refresh_list();
        // SAFETY: the entry was generated for the program of this step and for this layout of the
        // frame. Its memory lives as long as the detours, which are borrowed here. It accesses
        // slots and marks only below the number of slots that the program fixes, and updates only
        // below `room`; it keeps no pointer into a vector across a call to the host. `run` is not
        // used here until it returns.
        let stopped = unsafe { entry(&raw mut frame) };
        let done = match stopped {
            0 => {
                // all sequences have ended, so the other lists are already settled
                frame.settle_list();
                Ok(())
            }
            _ => {
                frame.set_lengths();
                Err(RuleStopped)
            }
        };
        let Self { answer, panic, .. } = frame;
        answer.discard();
        if let Some(payload) = panic {
            resume_unwind(payload);
        }
        done
    }

    fn run(&mut self) -> &mut StepContext<'static> {
        // SAFETY: the pointer stems from the exclusive borrow that `enter` holds and does not use
        // meanwhile. The reference does not outlive the call to the host, during which native code
        // is suspended.
        unsafe { &mut *self.run }
    }

    /// Sets the lengths of the vectors to what native code has written.
    fn set_lengths(&mut self) {
        self.settle_list();
        let (held, covered) = (self.held_length, self.covered_length);
        let UpdateLists {
            saved: held_list,
            covered: covered_list,
            ..
        } = self.run().update_lists();
        // SAFETY: native code has initialised the elements of both lists up to these lengths, which
        // do not exceed the capacities stored in the frame.
        unsafe {
            held_list.set_len(held);
            covered_list.set_len(covered);
        }
    }

    #[inline]
    fn settle_list(&mut self) {
        let length = self.length;
        // SAFETY: native code has initialised the updates up to `length`, which does not exceed the
        // capacity stored in the frame.
        unsafe { self.run().update_lists().updates.set_len(length) }
    }

    /// Reloads pointers, lengths and capacities of all vectors.
    fn refresh(&mut self) {
        self.refresh_list();
        let UpdateLists {
            updates,
            saved: held,
            covered,
            ..
        } = self.run().update_lists();
        let room = (updates.capacity() - updates.len())
            .min(held.capacity() - held.len())
            .min(covered.capacity() - covered.len());
        let (held, held_length) = (held.as_mut_ptr(), held.len());
        let (covered, covered_length) = (covered.as_mut_ptr(), covered.len());
        (self.held, self.held_length) = (held, held_length);
        (self.covered, self.covered_length) = (covered, covered_length);
        self.sequence_room = room;
    }

    /// Reloads those of all vectors except the lists for sequences, which are empty on entry.
    #[inline]
    fn refresh_list(&mut self) {
        // SAFETY: as in `run`; the step context does not overlap the frame, whose other fields are
        // borrowed.
        let run = unsafe { &mut *self.run };
        self.slots = run.slots_mut().as_mut_ptr();
        self.locals = run.locals.as_mut_ptr();
        let lists = run.update_lists();
        self.marks = lists.marks.as_mut_ptr();
        self.epoch = lists.epoch;
        (self.list, self.length) = (lists.updates.as_mut_ptr(), lists.updates.len());
        self.room = lists.updates.capacity();
    }

    /// Runs `work` outside native code, with the frame of locals and the call depth of an inlined
    /// routine. After a panic, of this call or of an earlier one, returns `stopped`, with which native code ends soon.
    fn outside<T>(
        &mut self,
        place: u64,
        stopped: T,
        work: impl FnOnce(&mut StepContext<'static>, &mut Value) -> T,
    ) -> T {
        if self.panic.is_some() {
            return stopped;
        }
        self.set_lengths();
        let (base, depth) = (place as u32 as usize, (place >> 32) as u32 + self.depth);
        // SAFETY: as in `run`; the step context does not overlap the frame, whose `answer` is
        // borrowed.
        let run = unsafe { &mut *self.run };
        let outer = (run.base, run.depth);
        (run.base, run.depth) = (base, depth);
        if run.locals.len() < self.needed {
            run.locals.resize(self.needed, Value::Undef);
        }
        let answer = &mut self.answer;
        let result = on_enough_stack(|| caught(|| work(run, answer)));
        (run.base, run.depth) = outer;
        self.refresh();
        result.unwrap_or_else(|payload| {
            self.answer = Value::Undef;
            self.panic = Some(payload);
            stopped
        })
    }
}

/// Returns the result of `work`, or its panic, which must not unwind through native code.
pub(crate) fn caught<T>(work: impl FnOnce() -> T) -> Result<T, PanicPayload> {
    // what `work` leaves behind is not used any more: the panic is resumed
    catch_unwind(AssertUnwindSafe(work))
}

/// Packs the position of a call to the host: the first local of its frame, and its call depth.
pub(crate) fn pack_call_position(base: u32, depth: u32) -> i64 {
    i64::from(base) | i64::from(depth) << 32
}

/// The host functions that native code calls. The table in [`super::emit`] uses their names.
///
/// The first argument is always the frame that `enter` created; it is alive and not borrowed
/// elsewhere.
pub(crate) mod out {
    use super::{
        Atom, Choosing, Detour, FaultKind, KleeneTruth, NativeFrame, Origin, StepContext, Value,
        caught,
    };

    fn detour(frame: &NativeFrame, index: u32) -> &'static Detour {
        // SAFETY: generated code contains only indices of detours created together with it, and
        // `enter` borrows those while it runs.
        unsafe { &*frame.detours.add(index as usize) }
    }

    fn stopped(done: bool) -> u8 {
        u8::from(!done)
    }

    /// Runs the closure of a rule.
    pub extern "C" fn rule(frame: &mut NativeFrame, index: u32, place: u64) -> u8 {
        let Detour::Rule(rule) = detour(frame, index) else {
            return 1;
        };
        stopped(frame.outside(place, false, |run, _| rule(run).is_ok()))
    }

    /// Runs the closure of a rule in a layer that is applied; returns 2 if its set is empty.
    pub extern "C" fn layered(frame: &mut NativeFrame, index: u32, place: u64) -> u8 {
        let Detour::Rule(rule) = detour(frame, index) else {
            return 1;
        };
        frame.outside(place, 1, |run, _| match run.run_applying(rule) {
            Ok(false) => 0,
            Ok(true) => 2,
            Err(_) => 1,
        })
    }

    /// Evaluates the closure of a guard; returns 0 for false, 1 for true, 2 for a fault.
    pub extern "C" fn guard(frame: &mut NativeFrame, index: u32, place: u64, origin: u32) -> u8 {
        let Detour::Truth(truth) = detour(frame, index) else {
            return 2;
        };
        frame.outside(place, 2, |run, _| {
            let holds = truth(run);
            match holds {
                _ if run.has_failed() => 2,
                KleeneTruth::False => 0,
                KleeneTruth::True => 1,
                KleeneTruth::Undef => {
                    run.fail(FaultKind::UndefinedGuard, Origin(origin));
                    2
                }
            }
        })
    }

    /// Evaluates the closure of a Boolean term; returns 2 for undef.
    pub extern "C" fn truth(frame: &mut NativeFrame, index: u32, place: u64) -> u8 {
        let Detour::Truth(truth) = detour(frame, index) else {
            return 2;
        };
        frame.outside(place, 2, |run, _| {
            let holds = truth(run);
            match holds {
                _ if run.take_failure() => 2,
                KleeneTruth::False => 0,
                KleeneTruth::True => 1,
                KleeneTruth::Undef => 2,
            }
        })
    }

    /// Evaluates the closure of a term and stores the value in the frame's `answer`.
    pub extern "C" fn term(frame: &mut NativeFrame, index: u32, place: u64) {
        if let Detour::Term(term) = detour(frame, index) {
            frame.outside(place, (), |run, answer| {
                let value = term(run);
                *answer = if run.take_failure() {
                    Value::Undef
                } else {
                    value
                };
            });
        }
    }

    /// Evaluates the closure of a term and stores the value in a local; returns 1 for a fault.
    pub extern "C" fn bind(frame: &mut NativeFrame, index: u32, place: u64, local: u32) -> u8 {
        let Detour::Term(term) = detour(frame, index) else {
            return 1;
        };
        frame.outside(place, 1, |run, _| {
            let value = term(run);
            run.locals[local as usize] = value;
            u8::from(run.take_failure())
        })
    }

    /// Stores a scalar in a local, where closures can read it.
    pub extern "C" fn spill(frame: &mut NativeFrame, local: u32, tag: u32, payload: i64) {
        let needed = frame.needed;
        let locals = &mut frame.run().locals;
        if locals.len() < needed {
            locals.resize(needed, Value::Undef);
        }
        locals[local as usize] = scalar(tag, payload);
    }

    /// Returns how the value of a variable with this range is chosen: 0 by index, 1 the first
    /// candidate, 2 picked from outside.
    pub extern "C" fn way(frame: &mut NativeFrame, range: u32) -> u8 {
        let choosing = frame.asked(|run| run.choosing(Origin(range)));
        match choosing {
            Some(Choosing::ByNumber) => 0,
            Some(Choosing::First) | None => 1,
            Some(Choosing::Picked) => 2,
        }
    }

    /// Returns the index of the chosen one of `count` candidates.
    pub extern "C" fn choose(frame: &mut NativeFrame, count: u64, origin: u32) -> u64 {
        let chosen = frame.asked(|run| run.choose(count as usize, Origin(origin)) as u64);
        chosen.unwrap_or_default()
    }

    /// Records the fault of a loop with too many iterations.
    pub extern "C" fn endless(frame: &mut NativeFrame, most: u32, origin: u32, place: u64) {
        frame.outside(place, (), |run, _| {
            run.fail(FaultKind::Endless(most), Origin(origin));
        });
    }

    /// Opens a set within the current one.
    pub extern "C" fn open(frame: &mut NativeFrame) {
        frame.outside_here(StepContext::open_set);
    }

    /// Closes a set and applies it; returns 1 if it was empty.
    pub extern "C" fn apply(frame: &mut NativeFrame) -> u8 {
        u8::from(frame.outside_here(StepContext::apply_set))
    }

    /// Ends a sequence; returns 1 if it stopped with a clash.
    pub extern "C" fn restore(frame: &mut NativeFrame) -> u8 {
        stopped(frame.outside_here(|run| run.end_sequence().is_ok()))
    }

    /// Adds an update of a slot that has none in the current set.
    pub extern "C" fn write(frame: &mut NativeFrame, slot: u32, origin: u32) {
        let value = Value::clone(&frame.given);
        // cannot clash: generated code has checked the slot's mark
        frame.outside_here(|run| run.write_first(slot, value, Origin(origin)));
    }

    /// Adds an update in a sequence and applies it immediately.
    pub extern "C" fn write_through(frame: &mut NativeFrame, slot: u32, origin: u32) {
        let value = Value::clone(&frame.given);
        frame.outside_here(|run| run.write_through(slot, value, Origin(origin)));
    }

    impl NativeFrame {
        /// Asks the chooser, which changes no list; returns `None` after a panic.
        fn asked<T>(&mut self, ask: impl FnOnce(&mut StepContext<'static>) -> T) -> Option<T> {
            if self.panic.is_some() {
                return None;
            }
            let run = self.run();
            match caught(|| ask(run)) {
                Ok(answer) => Some(answer),
                Err(payload) => {
                    self.panic = Some(payload);
                    None
                }
            }
        }

        /// Runs `work` that executes no code of the program and needs no frame of locals.
        fn outside_here<T>(&mut self, work: impl FnOnce(&mut StepContext<'static>) -> T) -> T {
            self.set_lengths();
            let result = work(self.run());
            self.refresh();
            result
        }
    }

    fn scalar(tag: u32, payload: i64) -> Value {
        match tag as u8 {
            asmotion_value::layout::BOOL => Value::Bool(payload & 1 == 1),
            asmotion_value::layout::INT => Value::Int(payload),
            asmotion_value::layout::ATOM => Value::Atom(Atom(payload as u32)),
            _ => Value::Undef,
        }
    }
}
