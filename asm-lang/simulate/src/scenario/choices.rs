//! Choices: those picked first, the others by chance.

use crate::Seeded;
use ir::Origin;
use machine::Chooser;
use std::collections::BTreeMap;
use std::sync::Arc;
use value::Value;

/// Takes what was picked, and leaves the rest to the seed.
#[derive(Clone, Debug)]
pub(super) struct Choices {
    seeded: Seeded,
    picked: BTreeMap<Origin, Arc<[Option<Value>]>>,
}

impl Choices {
    pub fn new(seed: u64) -> Self {
        Self {
            seeded: Seeded::new(seed),
            picked: BTreeMap::new(),
        }
    }

    /// Picks a value for one of the variables of a `choose`; a later pick overrides an earlier one.
    pub fn pick(&mut self, choose: Origin, variables: usize, variable: usize, value: Value) {
        let known = self.picked.remove(&choose);
        let mut values = known.map_or_else(|| vec![None; variables], |known| known.to_vec());
        if let Some(place) = values.get_mut(variable) {
            *place = Some(value);
        }
        self.picked.insert(choose, values.into());
    }

    /// Forgets what was picked: a pick counts for one step.
    pub fn forget(&mut self) {
        self.picked.clear();
    }
}

impl Chooser for Choices {
    fn choose(&mut self, count: usize) -> usize {
        self.seeded.choose(count)
    }

    fn picked(&self, choose: Origin) -> Option<Arc<[Option<Value>]>> {
        self.picked.get(&choose).cloned()
    }
}
