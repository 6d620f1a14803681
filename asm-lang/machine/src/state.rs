//! States: the values of all locations.
//!
//! A [`MachineState`] has four parts. Only the first two constitute the state in the sense of ASMs:
//!
//! | part | contents | set by |
//! |---|---|---|
//! | [`Store`] | slots, extents of the domains, reserve | every step |
//! | [`InitialState`] | the store that the run began with | the first step; then fixed |
//! | [`Locations`] | the locations of slots beyond those fixed by the program | the first access to a location |
//! | [`Memo`] | cached results of queries and computations | any read |
//!
//! Steps read and write the store in place: a value is two words, and a slot is an index. For
//! storage, comparison and lookup, a state is packed: see [`PackedState`](crate::PackedState).

mod locations;
mod memo;
mod range_index;
mod store;

pub(crate) use locations::Locations;
pub(crate) use memo::Memo;
pub(crate) use range_index::{IndexKey, IndexState, RangeIndex};
pub(crate) use store::Store;

use asmotion_ir::{DomainId, FunctionId, Program, Slot, Storage};
use asmotion_value::Value;
use std::sync::Arc;

/// A state of a machine. Locations that were never accessed have their initial value implicitly.
#[derive(Clone)]
pub struct MachineState {
    pub(crate) store: Store,
    pub(crate) initial: InitialState,
    pub(crate) locations: Locations,
    pub(crate) memo: Memo,
}

/// The state at the start of a run, in which initial values are computed on first access.
#[derive(Clone, Default)]
pub(crate) struct InitialState {
    /// Initial value of each slot.
    pub slots: Vec<Value>,
    /// Initial elements of each domain.
    pub extents: Vec<Arc<Vec<Value>>>,
    /// Time of the first step, in nanoseconds.
    pub now_ns: i64,
    /// Lazy and interned slots whose initial value the environment provided in the first step, in
    /// order of access.
    pub provided: Vec<Slot>,
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

    /// Initialises a lazy slot with this value, in the current and in the initial state.
    pub(crate) fn materialise(&mut self, slot: Slot, value: Value) {
        self.store.slots[slot as usize] = value.clone();
        self.initial.slots[slot as usize] = value;
        self.locations.materialise(slot);
    }

    /// Returns `true` if an argument of the slot's location was outside its domain on first access.
    #[inline]
    pub(crate) fn is_outside(&self, slot: Slot) -> bool {
        let outside = &self.locations.outside;
        !outside.is_empty() && outside.binary_search(&slot).is_ok()
    }

    /// Allocates a slot for a location, with this value in the current and in the initial state.
    pub(crate) fn intern(
        &mut self,
        function: FunctionId,
        arguments: &[Value],
        value: Value,
        outside: bool,
    ) -> Slot {
        self.store.slots.push(value.clone());
        self.initial.slots.push(value);
        self.memo.read_in.push(0);
        self.locations.intern(function, arguments, outside)
    }

    /// Records a value from the environment in the first step as the initial value of a location.
    #[cold]
    pub(crate) fn set_initial(&mut self, slot: Slot, value: Value) {
        let initial = &mut self.initial;
        if slot >= self.locations.eager
            && initial.slots[slot as usize] != value
            && !initial.provided.contains(&slot)
        {
            initial.provided.push(slot);
        }
        initial.slots[slot as usize] = value;
    }

    /// Keeps the locations accessed since the last successful step.
    pub(crate) fn commit(&mut self) {
        self.locations.committed = self.store.slots.len();
        self.locations.commit_met();
    }

    /// Forgets the locations that were first accessed in a failed step.
    #[inline]
    pub(crate) fn forget_uncommitted(&mut self) {
        let locations = &self.locations;
        if locations.has_uncommitted_met() || self.store.slots.len() > locations.committed {
            self.forget_each_uncommitted();
        }
    }

    #[cold]
    fn forget_each_uncommitted(&mut self) {
        while let Some(slot) = self.locations.forget_last_met() {
            self.store.slots[slot as usize] = Value::Undef;
            self.initial.slots[slot as usize] = Value::Undef;
            if !self.initial.provided.is_empty() {
                self.initial.provided.retain(|provided| *provided != slot);
            }
        }
        let committed = self.locations.committed;
        while self.store.slots.len() > committed {
            self.store.slots.pop();
            self.initial.slots.pop();
            self.memo.read_in.pop();
            self.locations.forget_last();
        }
        self.initial
            .provided
            .retain(|provided| (*provided as usize) < committed);
        self.memo.windows.forget(committed as Slot);
    }

    /// Forgets all lazy and interned locations, together with everything cached about them.
    pub(crate) fn forget_materialised(&mut self) {
        let fixed = self.locations.fixed as usize;
        self.store.slots.truncate(fixed);
        self.initial.slots.truncate(fixed);
        self.initial.provided.clear();
        self.memo.read_in.truncate(fixed);
        self.memo.windows.forget(0);
        for slot in self.locations.forget_all() {
            self.store.slots[slot as usize] = Value::Undef;
            self.initial.slots[slot as usize] = Value::Undef;
        }
    }

    /// Returns the value of a slot.
    pub fn get(&self, slot: Slot) -> &Value {
        &self.store.slots[slot as usize]
    }

    /// Returns the initial value of a slot.
    pub fn get_initial(&self, slot: Slot) -> &Value {
        &self.initial.slots[slot as usize]
    }

    /// Returns the number of slots, including those of interned locations.
    pub fn slot_count(&self) -> usize {
        self.locations.committed
    }

    /// Returns the elements of a domain, in ascending order.
    pub fn extent(&self, domain: DomainId) -> &[Value] {
        &self.store.extents[domain.0 as usize]
    }

    /// Returns the slot of a location; `None` if it is neither fixed by the program nor interned.
    pub fn slot(
        &self,
        program: &Program,
        function: FunctionId,
        arguments: &[Value],
    ) -> Option<Slot> {
        match dense(program, function, arguments) {
            Some(slot) => self.locations.is_materialised(slot).then_some(slot),
            None => self.locations.find(function, arguments),
        }
    }

    /// Returns the function of a slot's location.
    pub fn function(&self, program: &Program, slot: Slot) -> Option<FunctionId> {
        match self.locations.get(slot) {
            Some((function, _)) => Some(*function),
            None => program.dense_function(slot),
        }
    }

    /// Returns the location of a slot.
    pub fn location(&self, program: &Program, slot: Slot) -> Option<(FunctionId, Vec<Value>)> {
        let function = self.function(program, slot)?;
        let mut arguments = Vec::new();
        self.arguments(program, slot, &mut arguments);
        Some((function, arguments))
    }

    /// Appends the arguments of a slot's location to a list.
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

    /// Iterates over the slots whose location is part of the state. Excludes lazy slots before
    /// their first access, and locations that only a failed step accessed.
    pub fn slots(&self) -> impl Iterator<Item = Slot> {
        let lazy = self.locations.committed_met();
        let interned = self.locations.fixed..self.locations.committed as Slot;
        (0..self.locations.eager).chain(lazy).chain(interned)
    }

    /// Lists the locations of the specification's own functions, sorted by function and arguments.
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

/// Returns the slot of a location if all arguments lie on the function's axes.
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
