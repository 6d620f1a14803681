//! The mapping between slots and locations.
//!
//! Slots below [`Program::slots`] are fixed by the program; those from `eager` on are *lazy* and
//! get their values on first access. All others are *interned* in order of access, so their numbers
//! depend on the history of the machine and have no meaning outside of it.

use asmotion_ir::{FunctionId, FunctionKind, Program, Slot};
use asmotion_value::Value;
use hashbrown::HashTable;
use rustc_hash::FxHasher;
use std::hash::{Hash, Hasher};

/// The lazy and interned locations that were accessed.
#[derive(Clone)]
pub(crate) struct Locations {
    /// Number of slots fixed by the program; the first interned slot has this number.
    pub fixed: Slot,
    /// Number of eager slots, which have a value from the start.
    pub eager: Slot,
    /// `true` for each lazy slot that was accessed.
    is_materialised: Vec<bool>,
    /// The lazy slots that were accessed, in order of first access.
    met: Vec<Slot>,
    /// Number of those that were accessed before or in the last successful step.
    committed_met: usize,
    /// Number of slots after the last successful step. Slots interned by a failed step are kept
    /// until the next one begins.
    pub committed: usize,
    /// Locations of the interned slots, in order of their numbers.
    pub interned: Vec<(FunctionId, Box<[Value]>)>,
    /// Interned slots, ascending, that had an argument outside its domain on first access.
    pub outside: Vec<Slot>,
    /// The interned slots, hashed by location.
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
        Self::beyond(program.eager, program.slots)
    }

    /// Creates the locations for a program with these numbers of eager and of fixed slots.
    fn beyond(eager: Slot, fixed: Slot) -> Self {
        Self {
            fixed,
            eager,
            is_materialised: vec![false; (fixed - eager) as usize],
            met: Vec::new(),
            committed_met: 0,
            committed: fixed as usize,
            interned: Vec::new(),
            outside: Vec::new(),
            slots: HashTable::new(),
        }
    }

    /// Returns the location of an interned slot.
    pub fn get(&self, slot: Slot) -> Option<&(FunctionId, Box<[Value]>)> {
        self.interned.get(slot.checked_sub(self.fixed)? as usize)
    }

    /// Returns the slot of an interned location.
    pub fn find(&self, function: FunctionId, arguments: &[Value]) -> Option<Slot> {
        let is_it = |&slot: &Slot| {
            let known = self.get(slot);
            known.is_some_and(|(known, with)| *known == function && **with == *arguments)
        };
        self.slots.find(hash(function, arguments), is_it).copied()
    }

    /// Returns `true` if a slot holds a value: an eager or interned slot, or a lazy one that was
    /// accessed.
    #[inline]
    pub fn is_materialised(&self, slot: Slot) -> bool {
        slot < self.eager || self.is_materialised.get((slot - self.eager) as usize) != Some(&false)
    }

    /// Marks a lazy slot as accessed; returns `false` if there is no such slot.
    pub fn materialise(&mut self, slot: Slot) -> bool {
        match self.is_materialised.get_mut((slot - self.eager) as usize) {
            Some(met) => {
                *met = true;
                self.met.push(slot);
                true
            }
            None => false,
        }
    }

    /// Keeps the lazy slots that were accessed.
    #[inline]
    pub fn commit_met(&mut self) {
        self.committed_met = self.met.len();
    }

    /// Returns `true` if lazy slots were first accessed after the last successful step.
    #[inline]
    pub fn has_uncommitted_met(&self) -> bool {
        self.met.len() > self.committed_met
    }

    /// Forgets the lazy slot accessed last, if that was after the last successful step.
    pub fn forget_last_met(&mut self) -> Option<Slot> {
        if !self.has_uncommitted_met() {
            return None;
        }
        let slot = self.met.pop()?;
        self.is_materialised[(slot - self.eager) as usize] = false;
        Some(slot)
    }

    /// Returns the lazy slots accessed before or in the last successful step, in ascending order.
    pub fn committed_met(&self) -> Vec<Slot> {
        let mut met = self.met[..self.committed_met].to_vec();
        met.sort_unstable();
        met
    }

    /// Interns a location and returns its slot.
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

    /// Removes the location interned last.
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

    /// Removes all interned locations and marks all lazy slots as not accessed. Returns those that were.
    pub fn forget_all(&mut self) -> Vec<Slot> {
        for slot in &self.met {
            self.is_materialised[(slot - self.eager) as usize] = false;
        }
        self.committed_met = 0;
        self.committed = self.fixed as usize;
        self.interned.clear();
        self.outside.clear();
        self.slots.clear();
        std::mem::take(&mut self.met)
    }

    /// Returns `true` if a slot is a local location of this run of a rule.
    pub fn is_local(&self, program: &Program, slot: Slot, run: i64) -> bool {
        self.get(slot).is_some_and(|(function, arguments)| {
            program.functions[function.0 as usize].kind == FunctionKind::Local
                && arguments.first() == Some(&Value::Int(run))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_forgotten_location_leaves_nothing_behind() {
        let mut locations = Locations::beyond(2, 3);
        let function = FunctionId(0);
        let arguments = |number| [Value::Int(number)];
        let kept = locations.intern(function, &arguments(0), false);
        for number in 1..100 {
            let slot = locations.intern(function, &arguments(number), number % 2 == 0);
            assert_eq!(locations.find(function, &arguments(number)), Some(slot));
            locations.forget_last();
            assert_eq!(locations.find(function, &arguments(number)), None);
            assert_eq!((locations.slots.len(), locations.outside.len()), (1, 0));
        }
        assert_eq!(locations.find(function, &arguments(0)), Some(kept));
    }
}
