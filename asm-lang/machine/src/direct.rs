//! Direct steps: native code that evaluates a whole step without the context that closures need.
//!
//! A direct rule has no detours. Where it meets something that it does not handle (undef, overflow, a possible clash), it
//! gives up, and the step is evaluated again from its beginning. This is sound because a direct rule changes nothing but the
//! update set. Choices are an exception, because the chooser is asked only once for each: the second evaluation repeats
//! those already made.

use crate::choose::{Chooser, Choosing};
use crate::record::StepChoice;
use crate::scratch::Scratch;
use crate::state::MachineState;
use crate::updates::UpdateLists;
use asmotion_ir::{DomainId, Origin};
use asmotion_value::Value;

/// A main rule as native code that handles whole steps.
pub trait DirectRule: Send + Sync {
    /// Collects the updates of a step, and applies them if the step asks for it. Apart from choices and coverage counters, a
    /// rule that gives up has no effect.
    ///
    /// The rule may be called only if it was compiled for the program whose step this is.
    fn collect(&self, step: &mut DirectStep<'_>) -> DirectResult;

    /// Returns `true` if the rule may be used in a state with these slots, and in all states that steps lead to from there.
    fn fits(&self, slots: &[Value]) -> bool;
}

/// The result of a direct rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DirectResult {
    /// The updates are complete, and they and the previous values are scalars.
    Scalars,
    /// The updates are complete, and some previous value is no scalar.
    Values,
    /// The rule gave up: closures evaluate the step.
    GaveUp,
}

/// Number of steps that a direct rule may give up, whatever their share: locations get their first values in such steps.
const MIN_MISSES: u64 = 64;

/// A direct rule is no longer used if it gave up more than one in this many steps.
const HITS: u64 = 4;

/// The steps of a machine that its direct rule was tried for.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct DirectUse {
    /// `true` if the rule fits the state and is tried for the next step; `false` after a change other than by a step.
    pub is_ready: bool,
    /// `true` if the rule gives up too often to be tried again.
    pub is_refused: bool,
    pub tried: u64,
    pub missed: u64,
}

impl DirectUse {
    /// Counts a step for which the rule gave up.
    pub fn miss(&mut self) {
        self.missed += 1;
        if self.missed > MIN_MISSES && self.missed > self.tried / HITS {
            self.is_ready = false;
            self.is_refused = true;
        }
    }
}

/// The parts of a machine that a direct rule accesses.
pub struct DirectStep<'a> {
    pub(crate) state: &'a mut MachineState,
    pub(crate) scratch: &'a mut Scratch,
    pub(crate) chooser: &'a mut dyn Chooser,
    /// `true` if the updates are to be applied.
    pub(crate) applies: bool,
}

impl DirectStep<'_> {
    /// Returns the values of all slots.
    #[inline(always)]
    pub fn slots_mut(&mut self) -> &mut [Value] {
        &mut self.state.store.slots
    }

    /// Returns the elements of a domain that is not an interval, in ascending order.
    pub fn extent(&self, domain: DomainId) -> &[Value] {
        let extent = self.state.store.extents.get(domain.0 as usize);
        extent.map_or(&[], |elements| elements.as_slice())
    }

    /// Returns the lists of the update set, which is empty at the start of a step.
    #[inline(always)]
    pub fn update_lists(&mut self) -> UpdateLists<'_> {
        self.scratch.updates.lists()
    }

    /// Returns the list for the previous values of the updated slots, empty at the start of a step, if the updates are to be
    /// applied.
    #[inline(always)]
    pub fn before(&mut self) -> Option<&mut Vec<Value>> {
        self.applies.then_some(&mut self.scratch.before)
    }

    /// Returns the coverage counters of the program. They stay in place during the step.
    #[inline(always)]
    pub fn counters(&mut self) -> &mut [u64] {
        &mut self.scratch.record.counts
    }

    /// Decides about a variable with this range and `count` candidates. Returns the index of the chosen one, and records the
    /// choice unless the first one is always taken; `None` if the value is picked from outside, whatever the candidates.
    #[inline]
    pub fn decide(&mut self, range: Origin, count: usize, origin: Origin) -> Option<usize> {
        match Choosing::by(self.chooser, range) {
            Choosing::ByNumber if count > 0 => Some(self.choose(count, origin)),
            Choosing::ByNumber | Choosing::First => Some(0),
            Choosing::Picked => None,
        }
    }

    /// Returns how a variable with this range is chosen.
    pub fn choosing(&self, range: Origin) -> Choosing {
        Choosing::by(self.chooser, range)
    }

    /// Returns the index of the chosen candidate, and records the choice. `count` is at least 1.
    #[inline]
    pub fn choose(&mut self, count: usize, origin: Origin) -> usize {
        self.scratch.record.choose(self.chooser, count, origin)
    }
}

/// Repeats choices, then asks a chooser for further ones.
pub(crate) struct RepeatedChoices<'a> {
    pub made: Vec<StepChoice>,
    pub next: usize,
    pub chooser: &'a mut dyn Chooser,
}

impl Chooser for RepeatedChoices<'_> {
    fn choose(&mut self, count: usize) -> usize {
        match self.made.get(self.next) {
            Some(choice) => {
                self.next += 1;
                choice.index
            }
            None => self.chooser.choose(count),
        }
    }

    fn takes_first(&self) -> bool {
        self.chooser.takes_first()
    }

    fn picked(&self, range: Origin) -> Option<Value> {
        self.chooser.picked(range)
    }
}
