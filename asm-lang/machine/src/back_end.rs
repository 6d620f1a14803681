//! The interface for native code: the access that code other than closures has to a step.
//!
//! Closures are the reference implementation and live in this crate. Native code lives in a crate
//! above, behind the trait [`NativeCompiler`], because a code generator is by far the largest
//! dependency of the language and most of its users (tests, checkers, tools) need none. The
//! direction of the dependency follows: the back end needs the program, the closures it falls back
//! on and the vectors of a step, and the machine needs nothing of the back end.
//!
//! The interface is as narrow as speed allows. Native code reads and writes three things in place,
//! since a call would cost more than the operation itself: the slots of the state, the locals, and
//! the lists of the update set ([`UpdateLists`]). It also keeps the counters in the public fields
//! of [`StepContext`] up to date. Everything else goes through the safe methods below. The machine
//! therefore contains no unsafe code for the back end; the back end's guarantees are stated next to
//! its own unsafe code.

pub use crate::choose::Choosing;
pub use crate::compile::Compiler;
pub use crate::direct::{DirectResult, DirectRule, DirectStep};
pub use crate::limits::{MAX_BINDINGS, MAX_CALLS, MAX_ITERATIONS};
pub use crate::run::code::{
    NativeCompiler, NativeRule, NoNativeCode, RuleCode, TermCode, TruthCode,
};
pub use crate::run::{KleeneTruth, RuleStopped, StepContext, on_enough_stack};
pub use crate::updates::{CoveredMark, Mark, SavedValue, UpdateLists};

use crate::fault::FaultKind;
use asmotion_ir::{Origin, Slot};
use asmotion_value::Value;

/// The implementation that executes the steps of a machine. All give the same steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BackEnd {
    /// Closures at first, native code once the machine has done a certain amount of work.
    #[default]
    Auto,
    /// Closures, which support every construct on every processor.
    Closures,
    /// Native code from the first step on, as far as it is supported.
    Native,
}

impl StepContext<'_> {
    /// Returns the values of all slots.
    #[inline]
    pub fn slots_mut(&mut self) -> &mut [Value] {
        &mut self.state.store.slots
    }

    /// Returns the lists of the update set.
    #[inline]
    pub fn update_lists(&mut self) -> UpdateLists<'_> {
        self.updates.lists()
    }

    /// Returns the coverage counters of the program. They stay in place until the step ends.
    #[inline]
    pub fn counters(&mut self) -> &mut [u64] {
        self.record.allocate_counts(self.program.counted.len());
        &mut self.record.counts
    }

    /// Returns `true` if a term failed or a rule stopped.
    pub fn has_failed(&self) -> bool {
        self.fault.is_some()
    }

    /// Returns `true` if part of a term failed, and discards the fault: the closure of the whole
    /// term runs next and encounters it again. A fault of the environment is kept, because the
    /// environment is asked only once in a step, and so is one of an initial value, which is computed only once.
    pub fn take_failure(&mut self) -> bool {
        let Some(fault) = self.fault.take() else {
            return false;
        };
        let is_of_input = matches!(
            fault.kind,
            FaultKind::Input { .. } | FaultKind::OutsideInput { .. }
        );
        if is_of_input || self.is_fault_final {
            self.fault = Some(fault);
        }
        true
    }

    /// Returns how a variable with this range is chosen.
    pub fn choosing(&self, range: Origin) -> Choosing {
        Choosing::by(self.chooser, range)
    }

    /// Returns the index of the chosen candidate, and records the choice. `count` is at least 1.
    pub fn choose(&mut self, count: usize, origin: Origin) -> usize {
        self.record.choose(self.chooser, count, origin)
    }

    /// Opens an update set within the innermost one.
    pub fn open_set(&mut self) {
        let layer = self.updates.open();
        self.updates.layers.push(layer);
    }

    /// Closes the innermost set and applies it to the state; returns `true` if it was empty.
    pub fn apply_set(&mut self) -> bool {
        match self.updates.layers.pop() {
            Some(layer) => {
                let is_empty = self.updates.is_empty(&layer);
                self.apply(layer);
                is_empty
            }
            None => true,
        }
    }

    /// Ends a sequence: restores the state before it, and merges its updates into the enclosing
    /// set.
    ///
    /// # Errors
    /// An update clashes with one of the enclosing set.
    pub fn end_sequence(&mut self) -> Result<(), RuleStopped> {
        match self.updates.layers.pop() {
            Some(layer) => self.restore(layer),
            None => Err(RuleStopped),
        }
    }

    /// Runs a rule in a set of its own and applies that set; returns `true` if it was empty.
    ///
    /// # Errors
    /// The rule stopped with a fault.
    pub fn run_applying(&mut self, rule: &RuleCode) -> Result<bool, RuleStopped> {
        let layer = self.updates.open();
        rule(self)?;
        let is_empty = self.updates.is_empty(&layer);
        self.apply(layer);
        Ok(is_empty)
    }

    /// Adds an update of a slot that has none in the innermost set yet.
    pub fn write_first(&mut self, slot: Slot, value: Value, origin: Origin) {
        // cannot clash: the caller has checked the slot's mark
        let _ = self.updates.write(slot, value, origin);
    }
}
