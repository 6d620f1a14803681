//! Values that depend on the state: each possible value with the condition under which it is the value.

use crate::bdd::{Bdd, BddStore};
use crate::error::SymbolicError;
use asmotion_lang::Value;
use std::collections::BTreeMap;

/// Possible values with their conditions, which exclude each other and are not false. Where no condition holds, there is no value,
/// because the evaluation failed or is not reached.
#[derive(Clone, Default)]
pub(crate) struct Guarded(BTreeMap<Value, Bdd>);

impl Guarded {
    /// The value under a condition.
    pub fn of(value: Value, path: &Bdd) -> Self {
        let mut guarded = Self::default();
        if !path.is_never() {
            guarded.0.insert(value, path.clone());
        }
        guarded
    }

    /// Adds a value under a condition that excludes those of other values.
    pub fn add(
        &mut self,
        store: &BddStore,
        value: Value,
        guard: &Bdd,
    ) -> Result<(), SymbolicError> {
        if guard.is_never() {
            return Ok(());
        }
        if let Some(known) = self.0.get_mut(&value) {
            *known = store.or(known, guard)?;
        } else {
            self.0.insert(value, guard.clone());
        }
        Ok(())
    }

    /// Adds values under conditions that exclude those here.
    pub fn join(&mut self, store: &BddStore, others: &Self) -> Result<(), SymbolicError> {
        others
            .0
            .iter()
            .try_for_each(|(value, guard)| self.add(store, value.clone(), guard))
    }

    /// Returns the values restricted to a condition.
    pub fn under(&self, store: &BddStore, path: &Bdd) -> Result<Self, SymbolicError> {
        if path.is_always() {
            return Ok(self.clone());
        }
        let mut restricted = Self::default();
        for (value, guard) in &self.0 {
            restricted.add(store, value.clone(), &store.and(guard, path)?)?;
        }
        Ok(restricted)
    }

    /// Returns the values outside of a condition.
    pub fn outside(&self, store: &BddStore, path: &Bdd) -> Result<Self, SymbolicError> {
        let mut restricted = Self::default();
        for (value, guard) in &self.0 {
            restricted.add(store, value.clone(), &store.without(guard, path)?)?;
        }
        Ok(restricted)
    }

    /// Returns the condition under which there is a value.
    pub fn defined(&self, store: &BddStore) -> Result<Bdd, SymbolicError> {
        store.any(self.0.values())
    }

    pub fn get(&self, value: &Value) -> Option<&Bdd> {
        self.0.get(value)
    }

    pub fn iter(&self) -> impl Iterator<Item = (&Value, &Bdd)> {
        self.0.iter()
    }

    pub fn len(&self) -> usize {
        self.0.len()
    }
}
