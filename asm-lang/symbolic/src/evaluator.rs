//! The state of a symbolic evaluation: variables, intermediate states of sequences, updates, faults.

use crate::bdd::{Bdd, BddStore};
use crate::encoding::{Code, Inputs, Slots};
use crate::error::SymbolicError;
use crate::fault::FaultClass;
use crate::guarded::Guarded;
use asmotion_lang::ir::{
    DomainElements, DomainId, FunctionId, FunctionKind, Origin, Program, Slot, Storage,
};
use asmotion_lang::{Machine, Value};
use std::collections::BTreeMap;

/// Limit for the combinations of values that one construct is evaluated with.
pub(crate) const MAX_COMBINATIONS: usize = 1 << 15;

/// Limit for nested calls.
const MAX_DEPTH: usize = 200;

/// The possible values of inputs.
pub(crate) type InputValues<'a> = &'a dyn Fn(FunctionId) -> Option<Vec<Value>>;

/// A fault of a step or a condition, with the condition under which it occurs.
pub(crate) struct GuardedFault {
    pub origin: Origin,
    pub class: FaultClass,
    pub guard: Bdd,
}

/// The updates of a location, by their places.
pub(crate) type Written = BTreeMap<Origin, Guarded>;

/// The updates of a layer.
pub(crate) type Layer = BTreeMap<Slot, Written>;

/// A choice within a step, with the condition under which it is made.
#[derive(Clone)]
pub(crate) struct MadeChoice {
    pub code: Code,
    pub made: Bdd,
}

/// A symbolic evaluation.
pub(crate) struct Evaluator<'a> {
    pub store: &'a BddStore<'a>,
    pub program: &'a Program,
    pub machine: &'a Machine,
    pub slots: &'a Slots,
    pub inputs: &'a mut Inputs,
    pub ranges: InputValues<'a>,
    /// Conditions are evaluated: their inputs are part of what is considered.
    pub is_condition: bool,
    /// The initial value of a location is evaluated.
    pub is_initial: bool,
    pub frames: Vec<Vec<Guarded>>,
    pub agent: Guarded,
    /// Values of the locations that the sequences around have changed.
    pub view: BTreeMap<Slot, Guarded>,
    pub layers: Vec<Layer>,
    /// The condition under which each input is read and not known before.
    pub reads: BTreeMap<usize, Bdd>,
    pub choices: Vec<MadeChoice>,
    pub faults: Vec<GuardedFault>,
    /// The condition under which the step has failed, or is none because it has other inputs or choices.
    pub stopped: Bdd,
    /// Values that the variables of a location cannot represent, with the place of the first update.
    pub escaped: BTreeMap<(Slot, Value), Origin>,
    /// The condition under which each counted rule runs.
    pub counted: BTreeMap<u32, Bdd>,
    pub cached: BTreeMap<u32, Value>,
}

impl<'a> Evaluator<'a> {
    pub fn new(
        store: &'a BddStore<'a>,
        machine: &'a Machine,
        slots: &'a Slots,
        inputs: &'a mut Inputs,
        ranges: InputValues<'a>,
    ) -> Self {
        Self {
            store,
            program: machine.program(),
            machine,
            slots,
            inputs,
            ranges,
            is_condition: false,
            is_initial: false,
            frames: Vec::new(),
            agent: Guarded::of(Value::Undef, &store.always()),
            view: BTreeMap::new(),
            layers: vec![Layer::new()],
            reads: BTreeMap::new(),
            choices: Vec::new(),
            faults: Vec::new(),
            stopped: store.never(),
            escaped: BTreeMap::new(),
            counted: BTreeMap::new(),
            cached: BTreeMap::new(),
        }
    }

    /// Excludes the steps under a condition.
    pub fn exclude(&mut self, guard: &Bdd) -> Result<(), SymbolicError> {
        self.stopped = self.store.or(&self.stopped, guard)?;
        Ok(())
    }

    /// Returns the part of a path on which the step continues.
    pub fn alive(&self, path: &Bdd) -> Result<Bdd, SymbolicError> {
        if self.stopped.is_never() {
            return Ok(path.clone());
        }
        self.store.without(path, &self.stopped)
    }

    /// Records a fault.
    pub fn fail(
        &mut self,
        class: FaultClass,
        origin: Origin,
        guard: &Bdd,
    ) -> Result<(), SymbolicError> {
        let guard = self.alive(guard)?;
        if guard.is_never() {
            return Ok(());
        }
        self.exclude(&guard)?;
        let same = |known: &&mut GuardedFault| known.origin == origin && known.class == class;
        if let Some(known) = self.faults.iter_mut().find(same) {
            known.guard = self.store.or(&known.guard, &guard)?;
        } else {
            self.faults.push(GuardedFault {
                origin,
                class,
                guard,
            });
        }
        Ok(())
    }

    /// Enters a body with these arguments.
    pub fn enter(
        &mut self,
        arguments: Vec<Guarded>,
        locals: u32,
        origin: Origin,
    ) -> Result<(), SymbolicError> {
        if self.frames.len() >= MAX_DEPTH {
            return Err(SymbolicError::unsupported(origin, "a recursion this deep"));
        }
        let mut frame = arguments;
        let undef = Guarded::of(Value::Undef, &self.store.always());
        frame.resize(frame.len().max(locals as usize), undef);
        self.frames.push(frame);
        Ok(())
    }

    pub fn leave(&mut self) {
        self.frames.pop();
    }

    pub fn local(&self, local: u32) -> Option<&Guarded> {
        self.frames.last()?.get(local as usize)
    }

    pub fn set_local(&mut self, local: u32, value: Guarded) {
        let frame = self.frames.last_mut();
        if let Some(known) = frame.and_then(|frame| frame.get_mut(local as usize)) {
            *known = value;
        }
    }

    /// Returns `true` if the environment provides the locations of a function.
    pub fn is_input(&self, function: FunctionId) -> bool {
        let function = self.program.functions.get(function.0 as usize);
        function.is_some_and(|it| matches!(it.kind, FunctionKind::Monitored | FunctionKind::Shared))
    }

    /// Returns the slot of a location that has one in every state.
    pub fn slot(&self, function: FunctionId, arguments: &[Value]) -> Option<Slot> {
        let function = self.program.functions.get(function.0 as usize)?;
        let Storage::Dense {
            base,
            axes,
            lazy: false,
            ..
        } = &function.storage
        else {
            return None;
        };
        let mut slot = *base;
        for (axis, argument) in axes.iter().zip(arguments) {
            slot += axis.over.index(argument)? * axis.stride;
        }
        (axes.len() == arguments.len() && slot < self.program.eager).then_some(slot)
    }

    /// Returns the value of a location with a slot.
    pub fn stored(&self, slot: Slot, path: &Bdd) -> Result<Guarded, SymbolicError> {
        if !self.is_initial {
            if let Some(changed) = self.view.get(&slot) {
                return changed.under(self.store, path);
            }
            if let Some(code) = self.slots.get(&slot) {
                let mut read = Guarded::default();
                for (value, guard) in code.values.iter().zip(&code.now.values) {
                    read.add(self.store, value.clone(), &self.store.and(guard, path)?)?;
                }
                return Ok(read);
            }
        }
        Ok(Guarded::of(self.machine.state().get(slot).clone(), path))
    }

    /// Returns the value of an input location.
    pub fn input(
        &mut self,
        function: FunctionId,
        arguments: &[Value],
        origin: Origin,
        path: &Bdd,
    ) -> Result<Guarded, SymbolicError> {
        let unknown = || SymbolicError::Input { origin, function };
        let ranges = self.ranges;
        let number = self.inputs.number(function, arguments, || ranges(function));
        let number = number.ok_or_else(unknown)?;
        let store = self.store;
        let input = self.inputs.all.get_mut(number).ok_or_else(unknown)?;
        let count = input.values.len();
        let (code, codes) = if self.is_condition {
            (&mut input.known, count + 1)
        } else {
            (&mut input.free, count)
        };
        if code.is_none() {
            *code = Some(Code::add(store, codes)?);
            self.inputs.is_late |= !arguments.is_empty();
        }
        let input = self.inputs.all.get(number).ok_or_else(unknown)?;
        let mut read = Guarded::default();
        let mut new = path.clone();
        for (index, value) in input.values.iter().enumerate() {
            let code = |code: &Option<Code>, index: usize| {
                code.as_ref().and_then(|it| it.values.get(index).cloned())
            };
            let known = code(&input.known, index);
            let guard = match (self.is_condition, known, code(&input.free, index)) {
                (true, Some(known), _) => known,
                (false, Some(known), Some(free)) => {
                    let unread = code(&input.known, count).unwrap_or_else(|| store.never());
                    new = store.and(path, &unread)?;
                    store.or(&known, &store.and(&unread, &free)?)?
                }
                (false, None, Some(free)) => free,
                (true, None, _) | (false, _, None) => store.never(),
            };
            read.add(store, value.clone(), &store.and(&guard, path)?)?;
        }
        if !self.is_condition {
            // the other codes stand for no value
            let none = store.without(path, &read.defined(store)?)?;
            self.exclude(&none)?;
        }
        let new = self.alive(&new)?;
        let known = self.reads.entry(number).or_insert_with(|| store.never());
        *known = store.or(known, &new)?;
        Ok(read)
    }

    /// Returns `true` if a value is an element of a domain.
    pub fn is_element(&self, domain: DomainId, value: &Value) -> bool {
        let Some(declared) = self.program.domains.get(domain.0 as usize) else {
            return true;
        };
        match declared.elements {
            DomainElements::Ints { low, high } => {
                matches!(value, Value::Int(number) if (low..=high).contains(number))
            }
            DomainElements::Open => true,
            DomainElements::Atoms { .. }
            | DomainElements::Computed(_)
            | DomainElements::Undefined => {
                let extent = self.machine.state().extent(domain);
                extent.binary_search(value).is_ok()
            }
        }
    }

    /// Opens a layer of updates.
    pub fn open(&mut self) {
        self.layers.push(Layer::new());
    }

    pub fn close(&mut self) -> Layer {
        self.layers.pop().unwrap_or_default()
    }

    /// Notes a value that an update gives to a location, if its variables cannot represent it.
    pub fn note(&mut self, slot: Slot, value: &Value, origin: Origin) {
        let is_known = match self.slots.get(&slot) {
            Some(code) => code.index(value).is_some(),
            None => self.machine.state().get(slot) == value,
        };
        if !is_known {
            let place = self.escaped.entry((slot, value.clone()));
            place.or_insert(origin);
        }
    }

    /// Adds an update to the innermost layer.
    pub fn write(
        &mut self,
        slot: Slot,
        value: &Guarded,
        origin: Origin,
    ) -> Result<(), SymbolicError> {
        let store = self.store;
        let mut value = if self.stopped.is_never() {
            value.clone()
        } else {
            value.outside(store, &self.stopped)?
        };
        let known = self.layers.last().and_then(|layer| layer.get(&slot));
        let (mut clash, mut same) = (store.never(), store.never());
        for (first, before) in known
            .iter()
            .flat_map(|known| known.values())
            .flat_map(Guarded::iter)
        {
            for (second, after) in value.iter() {
                let both = store.and(before, after)?;
                let place = if first == second {
                    &mut same
                } else {
                    &mut clash
                };
                *place = store.or(place, &both)?;
            }
        }
        self.fail(FaultClass::Clash, origin, &clash)?;
        value = value.outside(store, &store.or(&clash, &same)?)?;
        if let Some(layer) = self.layers.last_mut() {
            let written = layer.entry(slot).or_default();
            written.entry(origin).or_default().join(store, &value)?;
        }
        Ok(())
    }

    /// Applies the updates of a layer to the intermediate state.
    pub fn apply(&mut self, layer: &Layer) -> Result<(), SymbolicError> {
        for (slot, written) in layer {
            let changed = values(self.store, written)?;
            let before = self.stored(*slot, &self.store.always())?;
            let mut after = before.outside(self.store, &changed.defined(self.store)?)?;
            after.join(self.store, &changed)?;
            self.view.insert(*slot, after);
        }
        Ok(())
    }

    /// Adds later updates to earlier ones, which they replace.
    pub fn replace(&self, earlier: &mut Layer, later: Layer) -> Result<(), SymbolicError> {
        for (slot, written) in later {
            let changed = values(self.store, &written)?.defined(self.store)?;
            let kept = earlier.entry(slot).or_default();
            for before in kept.values_mut() {
                *before = before.outside(self.store, &changed)?;
            }
            for (origin, value) in &written {
                kept.entry(*origin).or_default().join(self.store, value)?;
            }
        }
        Ok(())
    }
}

/// Returns the values that the updates of a location give to it.
pub(crate) fn values(store: &BddStore, written: &Written) -> Result<Guarded, SymbolicError> {
    let mut all = Guarded::default();
    for value in written.values() {
        all.join(store, value)?;
    }
    Ok(all)
}
