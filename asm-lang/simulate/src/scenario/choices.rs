//! Choices of a scenario: picked values first, the rest by seed.

use crate::random::Seeded;
use asmotion_ir::Origin;
use asmotion_machine::Chooser;
use asmotion_value::Value;
use std::collections::BTreeMap;

/// Chooses the picked values, and all others by seed.
#[derive(Clone, Debug)]
pub(super) struct PickedChoices {
    seeded: Seeded,
    /// Picked values, by the place of the variable's range.
    picked: BTreeMap<Origin, Value>,
}

impl PickedChoices {
    pub fn new(seed: u64) -> Self {
        Self {
            seeded: Seeded::new(seed),
            picked: BTreeMap::new(),
        }
    }

    /// Picks a value for the variable with this range, replacing an earlier pick.
    pub fn pick(&mut self, range: Origin, value: Value) {
        self.picked.insert(range, value);
    }

    /// Discards all picks, which are valid for one step.
    pub fn forget(&mut self) {
        self.picked.clear();
    }
}

impl Chooser for PickedChoices {
    fn choose(&mut self, count: usize) -> usize {
        self.seeded.choose(count)
    }

    fn picked(&self, range: Origin) -> Option<Value> {
        self.picked.get(&range).cloned()
    }
}
