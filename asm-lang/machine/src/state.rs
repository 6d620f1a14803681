//! States: what every location holds.

use crate::near::Near;
use asmotion_ir::{DomainId, Elements, FunctionId, FunctionKind, Program, Slot, Storage};
use asmotion_value::{Atom, Names, RuleId, Value, element_name};
use hashbrown::HashTable;
use rustc_hash::FxHasher;
use std::collections::BTreeSet;
use std::fmt;
use std::hash::{Hash, Hasher};
use std::sync::Arc;

/// A state of a machine. Locations that were never met hold their initial value implicitly.
#[derive(Clone)]
pub struct State {
    /// What each slot holds.
    pub(crate) slots: Vec<Value>,
    /// What each slot held in the initial state: initial values of locations met later are computed
    /// there.
    pub(crate) initial: Vec<Value>,
    /// The elements of each domain in the initial state.
    pub(crate) initial_extents: Vec<Arc<Vec<Value>>>,
    /// The time of the initial state.
    pub(crate) initial_now: i64,
    /// How many slots there were after the last step that was done: those met in a step that failed
    /// are known only until the next one begins.
    committed: usize,
    /// In which step each slot was last asked of the environment.
    pub(crate) asked: Vec<u64>,
    /// The elements of each domain, ascending.
    pub(crate) extents: Vec<Arc<Vec<Value>>>,
    /// Values of closed static terms.
    pub(crate) caches: Vec<Option<Value>>,
    /// Shortcuts to interned locations.
    pub(crate) near: Near,
    /// The elements taken from the reserve, and each one's number within its domain.
    pub(crate) reserve: Vec<(DomainId, u32)>,
    interned: HashTable<Slot>,
    /// The locations of the slots beyond the fixed ones.
    pub(crate) locations: Locations,
    /// How many of the fixed slots have a value from the beginning.
    eager: Slot,
    /// Which of the other fixed slots were met.
    met: Vec<bool>,
    /// Those of them that were met since the last step that was done.
    uncommitted: Vec<Slot>,
}

/// The locations of interned slots, in the order they were met.
#[derive(Clone)]
pub(crate) struct Locations {
    /// How many slots are fixed: the first of these has the next number.
    fixed: Slot,
    met: Vec<(FunctionId, Box<[Value]>)>,
    /// Those of them, ascending, that had arguments outside their domains when they were met.
    outside: Vec<Slot>,
}

impl Locations {
    fn get(&self, slot: Slot) -> Option<&(FunctionId, Box<[Value]>)> {
        self.met.get(slot.checked_sub(self.fixed)? as usize)
    }

    /// Whether a slot is local state of this run of a rule.
    pub fn is_local(&self, program: &Program, slot: Slot, run: i64) -> bool {
        self.get(slot).is_some_and(|(function, arguments)| {
            program.functions[function.0 as usize].kind == FunctionKind::Local
                && arguments.first() == Some(&Value::Int(run))
        })
    }
}

fn hash(function: FunctionId, arguments: &[Value]) -> u64 {
    let mut hasher = FxHasher::default();
    function.hash(&mut hasher);
    arguments.hash(&mut hasher);
    hasher.finish()
}

impl State {
    pub(crate) fn new(program: &Program) -> Self {
        let extents = program
            .domains
            .iter()
            .map(|domain| Arc::new(listed(&domain.elements)))
            .collect();
        Self {
            slots: vec![Value::Undef; program.slots as usize],
            initial: Vec::new(),
            initial_extents: Vec::new(),
            initial_now: 0,
            committed: program.slots as usize,
            asked: vec![0; program.slots as usize],
            extents,
            caches: vec![None; program.caches as usize],
            near: Near::default(),
            reserve: Vec::new(),
            interned: HashTable::new(),
            locations: Locations {
                fixed: program.slots,
                met: Vec::new(),
                outside: Vec::new(),
            },
            eager: program.eager,
            met: vec![false; (program.slots - program.eager) as usize],
            uncommitted: Vec::new(),
        }
    }

    /// The slot of a location that was met before.
    pub(crate) fn find(&self, function: FunctionId, arguments: &[Value]) -> Option<Slot> {
        let is_it = |&slot: &Slot| {
            let known = self.locations.get(slot);
            known.is_some_and(|(known, with)| *known == function && **with == *arguments)
        };
        self.interned
            .find(hash(function, arguments), is_it)
            .copied()
    }

    /// Whether a slot holds what its location holds: a lazy one does after it was met.
    #[inline]
    pub(crate) fn is_met(&self, slot: Slot) -> bool {
        slot < self.eager || self.met.get((slot - self.eager) as usize) != Some(&false)
    }

    /// A lazy slot holds this value now and in the initial state.
    pub(crate) fn meet(&mut self, slot: Slot, value: Value) {
        self.slots[slot as usize] = value.clone();
        self.initial[slot as usize] = value;
        if let Some(met) = self.met.get_mut((slot - self.eager) as usize) {
            *met = true;
            self.uncommitted.push(slot);
        }
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
        let slot = self.slots.len() as Slot;
        if outside {
            self.locations.outside.push(slot);
        }
        self.locations.met.push((function, arguments.into()));
        self.slots.push(value.clone());
        self.initial.push(value);
        self.asked.push(0);
        let locations = &self.locations;
        self.interned
            .insert_unique(hash(function, arguments), slot, |&slot| {
                let known = locations.get(slot);
                known.map_or(0, |(function, arguments)| hash(*function, arguments))
            });
        slot
    }

    /// Keeps the locations that were met.
    pub(crate) fn commit(&mut self) {
        self.committed = self.slots.len();
        self.uncommitted.clear();
    }

    /// Forgets the locations that only a failed step met.
    #[inline]
    pub(crate) fn forget_uncommitted(&mut self) {
        if !self.uncommitted.is_empty() || self.slots.len() > self.committed {
            self.forget_each_uncommitted();
        }
    }

    #[cold]
    fn forget_each_uncommitted(&mut self) {
        while let Some(slot) = self.uncommitted.pop() {
            self.slots[slot as usize] = Value::Undef;
            self.initial[slot as usize] = Value::Undef;
            self.met[(slot - self.eager) as usize] = false;
        }
        while self.slots.len() > self.committed {
            self.slots.pop();
            self.initial.pop();
            self.asked.pop();
            let slot = self.slots.len() as Slot;
            self.locations.outside.pop_if(|last| *last == slot);
            if let Some((function, arguments)) = self.locations.met.pop() {
                let found = self
                    .interned
                    .find_entry(hash(function, &arguments), |&known| known == slot);
                if let Ok(entry) = found {
                    entry.remove();
                }
            }
        }
        self.near.forget(self.committed as Slot);
    }

    /// A new element for a domain.
    pub(crate) fn fresh(&mut self, program: &Program, domain: DomainId) -> Atom {
        let last = self
            .reserve
            .iter()
            .rev()
            .find(|(known, _)| *known == domain);
        let number = last.map_or(1, |(_, number)| number + 1);
        self.reserve.push((domain, number));
        Atom((program.symbols.atoms.len() + self.reserve.len() - 1) as u32)
    }

    /// The domain an atom was declared in or taken for.
    pub(crate) fn domain_of(&self, program: &Program, atom: Atom) -> Option<DomainId> {
        let index = atom.0 as usize;
        match program.symbols.atom_domains.get(index) {
            Some(&domain) => Some(domain),
            None => self
                .reserve
                .get(index - program.symbols.atoms.len())
                .map(|(domain, _)| *domain),
        }
    }

    /// What a slot holds.
    pub fn get(&self, slot: Slot) -> &Value {
        &self.slots[slot as usize]
    }

    /// What a slot held in the initial state.
    pub fn get_initial(&self, slot: Slot) -> &Value {
        &self.initial[slot as usize]
    }

    /// How many slots there are.
    pub fn len(&self) -> usize {
        self.committed
    }

    /// Whether there is no location at all.
    pub fn is_empty(&self) -> bool {
        self.committed == 0
    }

    /// The elements a domain has now, ascending.
    pub fn extent(&self, domain: DomainId) -> &[Value] {
        &self.extents[domain.0 as usize]
    }

    /// The slot of a location, if it was met or is fixed.
    pub fn slot(
        &self,
        program: &Program,
        function: FunctionId,
        arguments: &[Value],
    ) -> Option<Slot> {
        match dense(program, function, arguments) {
            Some(slot) => self.is_met(slot).then_some(slot),
            None => self.find(function, arguments),
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
        let met_in_vain: BTreeSet<Slot> = self.uncommitted.iter().copied().collect();
        (0..self.committed as Slot)
            .filter(move |slot| self.is_met(*slot) && !met_in_vain.contains(slot))
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

/// The elements of a domain that are known from the program alone.
fn listed(elements: &Elements) -> Vec<Value> {
    match elements {
        // intervals are ranged over without listing them; see `extent`
        Elements::Ints { .. } => Vec::new(),
        Elements::Atoms { first, count } => (first.0..first.0 + count)
            .map(|atom| Value::Atom(Atom(atom)))
            .collect(),
        Elements::Computed(_) | Elements::Undefined | Elements::Open => Vec::new(),
    }
}

/// The names of the atoms and rules of a running machine.
#[derive(Clone, Copy)]
pub struct Naming<'a> {
    /// Knows what was declared.
    pub program: &'a Program,
    /// Knows what was taken from the reserve.
    pub reserve: &'a [(DomainId, u32)],
}

impl Names for Naming<'_> {
    fn atom(&self, atom: Atom, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let index = atom.0 as usize;
        let symbols = &self.program.symbols;
        if let Some(name) = symbols.atoms.get(index) {
            return to.write_str(name);
        }
        match self.reserve.get(index - symbols.atoms.len()) {
            Some((domain, number)) => {
                to.write_str(&element_name(&symbols.domains[domain.0 as usize], number))
            }
            None => write!(to, "atom!{index}"),
        }
    }

    fn rule(&self, rule: RuleId, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.program.symbols.rules.get(rule.0 as usize) {
            Some(name) => write!(to, "<<{name}>>"),
            None => write!(to, "<<rule {}>>", rule.0),
        }
    }
}
