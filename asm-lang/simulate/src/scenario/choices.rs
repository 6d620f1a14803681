//! Choices: those picked first, the others by chance.

use crate::random::Seeded;
use asmotion_ir::Origin;
use asmotion_machine::Chooser;
use asmotion_value::Value;
use std::collections::BTreeMap;

/// Takes what was picked, and leaves the rest to the seed.
#[derive(Clone, Debug)]
pub(super) struct PickedChoices {
    seeded: Seeded,
    /// By the place of the variable's range.
    picked: BTreeMap<Origin, Value>,
}

impl PickedChoices {
    pub fn new(seed: u64) -> Self {
        Self {
            seeded: Seeded::new(seed),
            picked: BTreeMap::new(),
        }
    }

    /// Picks a value for the variable with this range; a later pick overrides an earlier one.
    pub fn pick(&mut self, range: Origin, value: Value) {
        self.picked.insert(range, value);
    }

    /// Forgets what was picked: a pick counts for one step.
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
