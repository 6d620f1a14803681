//! States: what every location holds.
//!
//! A [`MachineState`] has four parts, and only the first two are what it *is*:
//!
//! | part | contents | set by |
//! |---|---|---|
//! | [`Store`] | slots, extents of the domains, reserve | every step |
//! | [`InitialState`] | the store that the run began with | the first step; then fixed |
//! | [`Locations`] | which location a slot beyond the fixed ones is | a location met for the first time |
//! | [`Memo`] | what need not be computed or asked again | whatever reads |
//!
//! Code that steps reads and writes the store in place: a value is two words, and a slot is an index. To
//! keep a state, to compare it or to look it up, it is packed: see [`PackedState`](crate::PackedState).

mod locations;
mod memo;
mod store;

pub(crate) use locations::Locations;
pub(crate) use memo::Memo;
pub(crate) use store::Store;

use asmotion_ir::{DomainId, FunctionId, Program, Slot, Storage};
use asmotion_value::Value;
use std::collections::BTreeSet;
use std::sync::Arc;

/// A state of a machine. Locations that were never met hold their initial value implicitly.
#[derive(Clone)]
pub struct MachineState {
    pub(crate) store: Store,
    pub(crate) initial: InitialState,
    pub(crate) locations: Locations,
    pub(crate) memo: Memo,
}

/// The state that a run began with: initial values of locations met later are computed there.
#[derive(Clone, Default)]
pub(crate) struct InitialState {
    /// What each slot held.
    pub slots: Vec<Value>,
    /// The elements of each domain.
    pub extents: Vec<Arc<Vec<Value>>>,
    /// The time, in nanoseconds.
    pub now_ns: i64,
    /// Slots that are no eager ones and began with what the environment said in the first step, in the
    /// order they were met.
    pub heard: Vec<Slot>,
}

impl MachineState {
    pub(crate) fn new(program: &Program) -> Self {
        Self {
            store: Store::new(program),
            initial: InitialState::default(),
            locations: Locations::new(program),
            memo: Memo::new(program),
        }
    }

    /// A lazy slot holds this value now and in the initial state.
    pub(crate) fn meet(&mut self, slot: Slot, value: Value) {
        self.store.slots[slot as usize] = value.clone();
        self.initial.slots[slot as usize] = value;
        self.locations.meet(slot);
    }

    /// Whether a slot's location had arguments outside their domains when it was met.
    #[inline]
    pub(crate) fn is_outside(&self, slot: Slot) -> bool {
        let outside = &self.locations.outside;
        !outside.is_empty() && outside.binary_search(&slot).is_ok()
    }

    /// A new slot for a location, holding this value now and in the initial state.
    pub(crate) fn intern(
        &mut self,
        function: FunctionId,
        arguments: &[Value],
        value: Value,
        outside: bool,
    ) -> Slot {
        self.store.slots.push(value.clone());
        self.initial.slots.push(value);
        self.memo.asked.push(0);
        self.locations.intern(function, arguments, outside)
    }

    /// Notes what the environment said in the first step about a location: it held that initially.
    #[cold]
    pub(crate) fn began_with(&mut self, slot: Slot, value: Value) {
        let initial = &mut self.initial;
        if slot >= self.locations.eager
            && initial.slots[slot as usize] != value
            && !initial.heard.contains(&slot)
        {
            initial.heard.push(slot);
        }
        initial.slots[slot as usize] = value;
    }

    /// Keeps the locations that were met.
    pub(crate) fn commit(&mut self) {
        self.locations.committed = self.store.slots.len();
        self.locations.uncommitted.clear();
    }

    /// Forgets the locations that only a failed step met.
    #[inline]
    pub(crate) fn forget_uncommitted(&mut self) {
        let locations = &self.locations;
        if !locations.uncommitted.is_empty() || self.store.slots.len() > locations.committed {
            self.forget_each_uncommitted();
        }
    }

    #[cold]
    fn forget_each_uncommitted(&mut self) {
        while let Some(slot) = self.locations.uncommitted.pop() {
            self.store.slots[slot as usize] = Value::Undef;
            self.initial.slots[slot as usize] = Value::Undef;
            self.initial.heard.retain(|heard| *heard != slot);
            self.locations.met[(slot - self.locations.eager) as usize] = false;
        }
        let committed = self.locations.committed;
        while self.store.slots.len() > committed {
            self.store.slots.pop();
            self.initial.slots.pop();
            self.memo.asked.pop();
            self.locations.forget_last();
        }
        self.initial
            .heard
            .retain(|heard| (*heard as usize) < committed);
        self.memo.near.forget(committed as Slot);
    }

    /// Forgets all locations that were met, and what is remembered of them.
    pub(crate) fn forget_met(&mut self) {
        let fixed = self.locations.fixed as usize;
        let lazy = self.locations.eager as usize..fixed;
        self.store.slots.truncate(fixed);
        self.store.slots[lazy.clone()].fill(Value::Undef);
        self.initial.slots.truncate(fixed);
        self.initial.slots[lazy].fill(Value::Undef);
        self.initial.heard.clear();
        self.memo.asked.truncate(fixed);
        self.memo.near.forget(0);
        self.locations.forget_all();
    }

    /// What a slot holds.
    pub fn get(&self, slot: Slot) -> &Value {
        &self.store.slots[slot as usize]
    }

    /// What a slot held in the initial state.
    pub fn get_initial(&self, slot: Slot) -> &Value {
        &self.initial.slots[slot as usize]
    }

    /// How many slots there are.
    pub fn len(&self) -> usize {
        self.locations.committed
    }

    /// Whether there is no location at all.
    pub fn is_empty(&self) -> bool {
        self.locations.committed == 0
    }

    /// The elements a domain has now, ascending.
    pub fn extent(&self, domain: DomainId) -> &[Value] {
        &self.store.extents[domain.0 as usize]
    }

    /// The slot of a location, if it was met or is fixed.
    pub fn slot(
        &self,
        program: &Program,
        function: FunctionId,
        arguments: &[Value],
    ) -> Option<Slot> {
        match dense(program, function, arguments) {
            Some(slot) => self.locations.is_met(slot).then_some(slot),
            None => self.locations.find(function, arguments),
        }
    }

    /// The function one of whose locations a slot is.
    pub fn function(&self, program: &Program, slot: Slot) -> Option<FunctionId> {
        match self.locations.get(slot) {
            Some((function, _)) => Some(*function),
            None => program.dense_function(slot),
        }
    }

    /// The location of a slot.
    pub fn location(&self, program: &Program, slot: Slot) -> Option<(FunctionId, Vec<Value>)> {
        let function = self.function(program, slot)?;
        let mut arguments = Vec::new();
        self.arguments(program, slot, &mut arguments);
        Some((function, arguments))
    }

    /// Adds the arguments of a slot's location to a list.
    pub(crate) fn arguments(&self, program: &Program, slot: Slot, to: &mut Vec<Value>) {
        if let Some((_, arguments)) = self.locations.get(slot) {
            return to.extend(arguments.iter().cloned());
        }
        let function = program
            .dense_function(slot)
            .map(|id| &program.functions[id.0 as usize].storage);
        if let Some(Storage::Dense { base, axes, .. }) = function {
            let mut rest = slot - base;
            for axis in axes {
                to.push(axis.over.argument(rest / axis.stride));
                rest %= axis.stride;
            }
        }
    }

    /// The slots whose locations are part of the state: they hold what their location holds, and were
    /// not met by a step that failed.
    pub fn slots(&self) -> impl Iterator<Item = Slot> {
        let met_in_vain: BTreeSet<Slot> = self.locations.uncommitted.iter().copied().collect();
        (0..self.locations.committed as Slot)
            .filter(move |slot| self.locations.is_met(*slot) && !met_in_vain.contains(slot))
    }

    /// All locations and what they hold, by function and arguments; those of the specification only.
    pub fn locations(&self, program: &Program) -> Vec<(FunctionId, Vec<Value>, Slot)> {
        let known = self.slots().filter_map(|slot| {
            let (function, arguments) = self.location(program, slot)?;
            program.functions[function.0 as usize]
                .own
                .then_some((function, arguments, slot))
        });
        let mut all: Vec<(FunctionId, Vec<Value>, Slot)> = known.collect();
        all.sort();
        all
    }
}

/// The slot of a location whose arguments all lie on the function's axes.
pub(crate) fn dense(program: &Program, function: FunctionId, arguments: &[Value]) -> Option<Slot> {
    let Storage::Dense { base, axes, .. } = &program.functions[function.0 as usize].storage else {
        return None;
    };
    let mut slot = *base;
    for (axis, argument) in axes.iter().zip(arguments) {
        slot += axis.over.index(argument)? * axis.stride;
    }
    Some(slot)
}
