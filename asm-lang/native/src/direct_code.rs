//! The state of the generation of a direct rule.

use crate::direct_frame::MAX_EXTENTS;
use crate::value_facts::ValueFacts;
use asmotion_ir::{DomainId, FunctionId, Slot};
use asmotion_machine::back_end::{MAX_BINDINGS, MAX_CALLS};
use cranelift_codegen::ir::Value;
use cranelift_frontend::Variable;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Limit for the number of updates of a direct step.
const MAX_UPDATES: u64 = 1 << 23;

/// The code of a direct rule, which has no detours: it gives up instead.
pub(crate) struct DirectCode {
    /// Address of the next update.
    pub next_update: Variable,
    /// Number of bytes by which the code since the last jump has advanced it already.
    pub pending: i32,
    pub first_update: Value,
    /// Address of the slots, which stay in place during a direct step.
    pub slots: Value,
    /// Number of iterations of all loops so far.
    pub iterations: Variable,
    /// `true` if all slots that are updated hold scalars.
    pub holds_scalars: bool,
    /// The functions whose locations are updated at most once in a step, indexed by function.
    pub clash_free: Vec<bool>,
    pub facts: Arc<ValueFacts>,
    /// Number of times that the code generated next is executed at most in a step.
    pub repetitions: u64,
    /// Greatest possible numbers of updates, of bindings and of calls.
    pub updates: u64,
    pub bindings: u64,
    pub calls: u64,
    /// `true` if the rule gives up in each step.
    pub is_futile: bool,
    /// The domains whose elements the rule enumerates, at most [`MAX_EXTENTS`].
    pub extents: Vec<DomainId>,
    pub sequence: DirectSequence,
}

/// The sequence that is being generated.
#[derive(Default)]
pub(crate) struct DirectSequence {
    pub slots: BTreeMap<Slot, SequenceSlot>,
    /// For each loop around the code, outermost first, a flag that is set by a write.
    pub writes: Vec<Variable>,
}

/// A slot that the sequence updates.
#[derive(Clone, Copy)]
pub(crate) struct SequenceSlot {
    pub function: FunctionId,
    /// The current value.
    pub value: Variable,
    /// Address of its update; 0 before the first write.
    pub update: Variable,
}

impl DirectCode {
    /// Returns the greatest possible number of updates in a step, if direct steps keep all limits.
    pub fn updates(&self) -> Option<usize> {
        // the main rule is the first call
        let is_bounded = self.bindings <= u64::from(MAX_BINDINGS)
            && self.calls < u64::from(MAX_CALLS)
            && self.updates <= MAX_UPDATES;
        (is_bounded && !self.is_futile).then_some(self.updates as usize)
    }

    /// Returns `true` if the rule may enumerate a domain that rules extend.
    pub fn may_use_extent(&self, domain: DomainId) -> bool {
        self.extents.len() < MAX_EXTENTS || self.extents.contains(&domain)
    }

    /// Returns the index of a domain among those that the rule enumerates.
    pub fn extent(&mut self, domain: DomainId) -> Option<usize> {
        if let Some(index) = self.extents.iter().position(|known| *known == domain) {
            return Some(index);
        }
        self.may_use_extent(domain).then(|| {
            self.extents.push(domain);
            self.extents.len() - 1
        })
    }

    /// Returns `true` if the code generated next is executed at most once in a step.
    pub fn is_executed_once(&self) -> bool {
        self.repetitions == 1
    }

    /// Returns `true` if no location of a function is updated twice in a step.
    pub fn is_clash_free(&self, function: FunctionId) -> bool {
        let free = self.clash_free.get(function.0 as usize);
        free.copied().unwrap_or(false)
    }

    /// Returns the number of iterations of all loops so far.
    pub fn iterations(&self) -> Variable {
        self.iterations
    }

    /// Returns the address of the next update.
    pub fn next_update(&self) -> Variable {
        self.next_update
    }

    /// Adds to the greatest possible number of updates.
    pub fn add_updates(&mut self, count: u64) {
        self.updates = self.updates.saturating_add(count);
    }
}
