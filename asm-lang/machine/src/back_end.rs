//! The seam to the native back end: what code that is no closure sees and does of a step.
//!
//! Closures are the reference and live in this crate. Native code lives in a crate above, behind the
//! trait [`NativeCompiler`], because a code generator is by far the largest dependency of the language
//! and most of its users do not need one: tests, checkers and tools do well with closures. A dependency
//! of the machine on its own back end would also be an arrow upwards: the back end needs the program,
//! the closures to fall back on and the vectors of a step, and the machine needs none of the back end.
//!
//! The seam is as narrow as speed allows. Native code reads and writes three things in place, since a
//! call for each would cost more than the work itself: the slots of the state, the locals, and the
//! lists of the update set ([`UpdateLists`]). The public fields of [`StepContext`] are counters that it keeps up
//! to date. All else goes through the methods below, which are safe; so the machine has no unsafe code
//! for the sake of the back end, and what the back end must guarantee is written where it is unsafe.

pub use crate::code::{NativeCompiler, NativeRule, NoNativeCode, RuleCode, TermCode, TruthCode};
pub use crate::compile::Compiler;
pub use crate::limits::{MAX_BINDINGS, MAX_CALLS, MAX_ITERATIONS};
pub use crate::run::{KleeneTruth, RuleStopped, StepContext, on_enough_stack};
pub use crate::updates::{CoveredMark, Mark, SavedValue, UpdateLists};

use crate::fault::FaultKind;
use crate::record::StepChoice;
use asmotion_ir::{Origin, Slot};
use asmotion_value::Value;

/// What does the steps of a machine. A step is the same, whichever does it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BackEnd {
    /// Closures at first, native code once the machine has done some steps.
    #[default]
    Auto,
    /// Closures: every construct on every processor.
    Closures,
    /// Native code as far as there is any, from the first step on.
    Native,
}

/// How the value of a variable of `choose` is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choosing {
    /// The chooser says which of the candidates, by a number.
    ByNumber,
    /// The first candidate is taken, and no choice is noted.
    First,
    /// The value was picked from outside.
    Picked,
}

impl StepContext<'_> {
    /// What each slot holds.
    #[inline]
    pub fn slots_mut(&mut self) -> &mut [Value] {
        &mut self.state.store.slots
    }

    /// The lists of the update set.
    #[inline]
    pub fn update_lists(&mut self) -> UpdateLists<'_> {
        self.updates.lists()
    }

    /// Whether a term failed, or a rule stopped.
    pub fn has_failed(&self) -> bool {
        self.fault.is_some()
    }

    /// Whether a part of a term failed. The fault is forgotten: the closure of the whole term, which is
    /// run next, meets it again. Only a fault of the environment stays, since the environment is asked
    /// once a step.
    pub fn take_failure(&mut self) -> bool {
        let Some(fault) = self.fault.take() else {
            return false;
        };
        if matches!(
            fault.kind,
            FaultKind::Input { .. } | FaultKind::OutsideInput { .. }
        ) {
            self.fault = Some(fault);
        }
        true
    }

    /// How a variable with this range is chosen.
    pub fn choosing(&self, range: Origin) -> Choosing {
        match self.chooser.picked(range) {
            Some(_) => Choosing::Picked,
            None if self.chooser.takes_first() => Choosing::First,
            None => Choosing::ByNumber,
        }
    }

    /// Which of `count` candidates is chosen, from 0; at least one is given. The choice is recorded.
    pub fn choose(&mut self, count: usize, origin: Origin) -> usize {
        let index = self.chooser.choose(count).min(count.saturating_sub(1));
        self.record.choices.push(StepChoice {
            origin,
            index,
            count,
        });
        index
    }

    /// Begins an update set within the innermost one.
    pub fn open_set(&mut self) {
        let layer = self.updates.open();
        self.updates.layers.push(layer);
    }

    /// Ends the innermost set and applies it to the state; whether it was empty.
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

    /// Ends a sequence: the state is as before it, its updates join the set around it.
    ///
    /// # Errors
    /// One of them clashes with an update of that set.
    pub fn end_sequence(&mut self) -> Result<(), RuleStopped> {
        match self.updates.layers.pop() {
            Some(layer) => self.restore(layer),
            None => Err(RuleStopped),
        }
    }

    /// Runs a rule in a set of its own and applies that; whether it was empty.
    ///
    /// # Errors
    /// The rule stopped.
    pub fn run_applying(&mut self, rule: &RuleCode) -> Result<bool, RuleStopped> {
        let layer = self.updates.open();
        rule(self)?;
        let is_empty = self.updates.is_empty(&layer);
        self.apply(layer);
        Ok(is_empty)
    }

    /// Adds the first update of a slot to the innermost set.
    pub fn write_first(&mut self, slot: Slot, value: Value, origin: Origin) {
        // no clash: the caller has looked at the slot's mark
        let _ = self.updates.write(slot, value, origin);
    }
}
