//! Buffers of steps.

use crate::record::{StepChoice, StepLog};
use crate::scalar_updates;
use crate::state::MachineState;
use crate::updates::Updates;
use crate::witness_notes::WitnessNotes;
use asmotion_value::Value;

/// Buffers of a step, reused by the next one.
#[derive(Default)]
pub(crate) struct Scratch {
    pub updates: Updates,
    pub record: StepLog,
    pub locals: Vec<Value>,
    pub stack: Vec<Value>,
    pub before: Vec<Value>,
    /// Number of steps and of atoms in the reserve before the last step.
    pub begun_at: (u64, usize),
    /// `true` if the last step wrote and replaced only scalars, so that no value needs to be
    /// dropped.
    pub is_plain: bool,
    /// `true` if a direct step used the buffers last.
    pub is_direct: bool,
    /// Coverage counters before a direct step.
    pub counts_before: Vec<u64>,
    /// Choices of a direct rule that gave up, to be repeated.
    pub missed: Vec<StepChoice>,
    /// Records of a failed step that is being repeated; otherwise `None`.
    pub notes: Option<WitnessNotes>,
}

impl Scratch {
    /// Clears the buffers of the last step.
    #[inline]
    pub fn begin(&mut self, now_ns: i64) {
        self.record.begin(now_ns);
        if self.is_plain {
            scalar_updates::forget(&mut self.before);
            scalar_updates::forget(&mut self.updates.list);
        } else {
            self.before.clear();
            self.updates.list.clear();
        }
        // assume non-scalars until this step has succeeded
        self.is_plain = false;
        self.is_direct = false;
    }

    #[inline(never)]
    pub fn save_counts(&mut self, count: usize) {
        self.record.allocate_counts(count);
        self.counts_before.clone_from(&self.record.counts);
    }

    /// Clears the buffers for a direct step after any other one.
    #[inline(never)]
    pub fn begin_directly(&mut self, steps: u64, state: &mut MachineState, now_ns: i64) {
        self.begin(now_ns);
        self.updates.begin(state.slot_count());
        state.forget_uncommitted();
        self.begun_at = (steps, state.store.reserve.len());
        // the lists are empty, and a direct step fills them with scalars unless it says otherwise
        (self.is_plain, self.is_direct) = (true, true);
    }

    /// Clears the buffers for a direct step after a direct step, which uses no others and creates no elements.
    #[inline(always)]
    pub fn begin_again(&mut self, steps: u64, now_ns: i64) {
        self.begun_at.0 = steps;
        self.record.choices.clear();
        self.record.now_ns = now_ns;
        scalar_updates::forget(&mut self.before);
        scalar_updates::forget(&mut self.updates.list);
        self.updates.begin_again();
    }

    /// Notes that the lists of a direct step contain values that have to be dropped.
    #[cold]
    pub fn forbid_shortcuts(&mut self) {
        (self.is_plain, self.is_direct) = (false, false);
    }
}

impl Clone for Scratch {
    /// Creates empty buffers: their contents do not outlive a step.
    fn clone(&self) -> Self {
        let record = StepLog {
            keeps_candidates: self.record.keeps_candidates,
            ..StepLog::default()
        };
        Self {
            record,
            ..Self::default()
        }
    }
}
