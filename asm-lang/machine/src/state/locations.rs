//! Which location each slot is.
//!
//! Slots below [`Program::slots`] are fixed by the program; those from `eager` on get their values when
//! they are met. All others are *interned* in the order they are met, so their numbers depend on the
//! history of a machine: nothing outside this machine may rely on them.

use asmotion_ir::{FunctionId, FunctionKind, Program, Slot};
use asmotion_value::Value;
use hashbrown::HashTable;
use rustc_hash::FxHasher;
use std::hash::{Hash, Hasher};

/// The locations of a state that were met.
#[derive(Clone)]
pub(crate) struct Locations {
    /// How many slots are fixed: the first interned one has the next number.
    pub fixed: Slot,
    /// How many of the fixed slots have a value from the beginning.
    pub eager: Slot,
    /// Which of the other fixed slots were met.
    pub met: Vec<bool>,
    /// Those of them that were met since the last step that was done.
    pub uncommitted: Vec<Slot>,
    /// How many slots there were after the last step that was done: those interned in a step that
    /// failed are known only until the next one begins.
    pub committed: usize,
    /// The locations of the interned slots.
    pub interned: Vec<(FunctionId, Box<[Value]>)>,
    /// Those of them, ascending, that had arguments outside their domains when they were met.
    pub outside: Vec<Slot>,
    /// Slots by their locations.
    slots: HashTable<Slot>,
}

fn hash(function: FunctionId, arguments: &[Value]) -> u64 {
    let mut hasher = FxHasher::default();
    function.hash(&mut hasher);
    arguments.hash(&mut hasher);
    hasher.finish()
}

impl Locations {
    pub fn new(program: &Program) -> Self {
        Self {
            fixed: program.slots,
            eager: program.eager,
            met: vec![false; (program.slots - program.eager) as usize],
            uncommitted: Vec::new(),
            committed: program.slots as usize,
            interned: Vec::new(),
            outside: Vec::new(),
            slots: HashTable::new(),
        }
    }

    /// The location of an interned slot.
    pub fn get(&self, slot: Slot) -> Option<&(FunctionId, Box<[Value]>)> {
        self.interned.get(slot.checked_sub(self.fixed)? as usize)
    }

    /// The slot of a location that was interned before.
    pub fn find(&self, function: FunctionId, arguments: &[Value]) -> Option<Slot> {
        let is_it = |&slot: &Slot| {
            let known = self.get(slot);
            known.is_some_and(|(known, with)| *known == function && **with == *arguments)
        };
        self.slots.find(hash(function, arguments), is_it).copied()
    }

    /// Whether a slot holds what its location holds: a lazy one does after it was met.
    #[inline]
    pub fn is_met(&self, slot: Slot) -> bool {
        slot < self.eager || self.met.get((slot - self.eager) as usize) != Some(&false)
    }

    /// Notes that a lazy slot was met; whether there is such a slot.
    pub fn meet(&mut self, slot: Slot) -> bool {
        match self.met.get_mut((slot - self.eager) as usize) {
            Some(met) => {
                *met = true;
                self.uncommitted.push(slot);
                true
            }
            None => false,
        }
    }

    /// Gives a location the next slot.
    pub fn intern(&mut self, function: FunctionId, arguments: &[Value], outside: bool) -> Slot {
        let slot = self.fixed + self.interned.len() as Slot;
        if outside {
            self.outside.push(slot);
        }
        self.interned.push((function, arguments.into()));
        let (fixed, interned) = (self.fixed, &self.interned);
        self.slots
            .insert_unique(hash(function, arguments), slot, |&slot| {
                let known = interned.get((slot - fixed) as usize);
                known.map_or(0, |(function, arguments)| hash(*function, arguments))
            });
        slot
    }

    /// Takes the last interned location back.
    pub fn forget_last(&mut self) {
        let Some((function, arguments)) = self.interned.pop() else {
            return;
        };
        let slot = self.fixed + self.interned.len() as Slot;
        self.outside.pop_if(|last| *last == slot);
        let found = self
            .slots
            .find_entry(hash(function, &arguments), |&known| known == slot);
        if let Ok(entry) = found {
            entry.remove();
        }
    }

    /// Forgets all interned locations, and which lazy slots were met.
    pub fn forget_all(&mut self) {
        self.met.fill(false);
        self.uncommitted.clear();
        self.committed = self.fixed as usize;
        self.interned.clear();
        self.outside.clear();
        self.slots.clear();
    }

    /// Whether a slot is local state of this run of a rule.
    pub fn is_local(&self, program: &Program, slot: Slot, run: i64) -> bool {
        self.get(slot).is_some_and(|(function, arguments)| {
            program.functions[function.0 as usize].kind == FunctionKind::Local
                && arguments.first() == Some(&Value::Int(run))
        })
    }
}
