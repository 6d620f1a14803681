//! The states of a finished exploration, as words.

use super::layout::WordLayout;
use super::machine_steps::words_of;
use super::store::{HashedState, WordStore};
use super::symmetry::WordSymmetry;
use crate::explore::WordStates;
use asmotion_ground::GroundProgram;
use asmotion_lang::Machine;
use std::fmt;

/// The states of a finished exploration.
pub(crate) struct StoredWords<const W: usize> {
    pub store: WordStore<W>,
    pub program: GroundProgram,
    pub layout: WordLayout,
    pub machine: Machine,
    pub symmetry: Option<WordSymmetry>,
}

impl<const W: usize> fmt::Debug for StoredWords<W> {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.debug_struct("StoredWords")
            .field("states", &self.store.len())
            .finish_non_exhaustive()
    }
}

impl<const W: usize> WordStates for StoredWords<W> {
    fn len(&self) -> usize {
        self.store.len()
    }

    fn bytes(&self, state: u32) -> Vec<u8> {
        let mut machine = self.machine.clone();
        let slots = machine.slots_mut();
        let words = self.store.get(state).unwrap_or([0; W]);
        for (variable, field) in self.program.variables.iter().zip(&self.layout.fields) {
            if let Some(slot) = slots.get_mut(variable.slot as usize) {
                *slot = variable.sort.value(field.number(field.get(&words)));
            }
        }
        let mut bytes = Vec::new();
        machine.pack_state(&mut bytes);
        bytes
    }

    fn number_of(&self, machine: &Machine) -> Option<u32> {
        let state = words_of(&self.program, &self.layout, machine)?;
        let symmetry = self.symmetry.as_ref();
        let state = symmetry.map_or(state, |symmetry| symmetry.canonical(&state));
        self.store.find(&HashedState::of(state)).ok()
    }

    fn is_compact(&self) -> bool {
        self.store.is_compact()
    }

    fn is_symmetric(&self) -> bool {
        self.symmetry.is_some()
    }

    fn memory(&self) -> usize {
        self.store.memory()
    }
}
