//! The last step of a coordinator that wrote something, for observers.
//!
//! It is kept as values, and formatted only when the status is read.

use asmotion_component::{Time, prefetch};
use asmotion_lang::ir::Slot;
use asmotion_lang::machine::{Machine, Step};
use asmotion_lang::simulate;
use asmotion_lang::value::Value;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A step that wrote something.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LastUpdate {
    /// Number of the step.
    pub step: u64,
    /// Time of the step in seconds of the run.
    pub at_s: f64,
    /// The update set, ordered by location: location and value.
    pub updates: BTreeMap<String, String>,
}

/// The last step that wrote something, as values.
#[derive(Debug, Default)]
pub(crate) struct LastWrite {
    /// Number of the step; 0 if the machine has made none that wrote something.
    step: u64,
    at: Time,
    /// The update set: slots of the machine, with their new values. The allocation is used again for the next step.
    updates: Vec<(Slot, Value)>,
    /// The step of a machine that was replaced, until the present one makes a step that writes something.
    before: Option<Box<LastUpdate>>,
}

impl LastWrite {
    /// Keeps a step that the machine has just made.
    pub fn note(&mut self, step: &Step<'_>, at: Time) {
        (self.step, self.at) = (step.number(), at);
        self.updates.clear();
        let updates = step.updates().iter();
        self.updates
            .extend(updates.map(|update| (update.slot, update.value.clone())));
        self.before = None;
    }

    /// Prefetches the list of updates.
    pub fn prefetch(&self) {
        prefetch(&*self.updates);
    }

    /// Returns the step as text. `machine` is the one that made it.
    pub fn text(&self, machine: &Machine) -> Option<LastUpdate> {
        if self.step == 0 {
            return self.before.as_deref().cloned();
        }
        let naming = machine.naming();
        let updates = self.updates.iter().map(|(slot, value)| {
            let location = simulate::location(machine, *slot);
            (location, value.show(&naming).to_string())
        });
        Some(LastUpdate {
            step: self.step,
            at_s: self.at.seconds(),
            updates: updates.collect(),
        })
    }

    /// Returns the step for a machine that replaces `machine`, in which slots have other meanings.
    pub fn for_successor(&self, machine: &Machine) -> Self {
        Self {
            before: self.text(machine).map(Box::new),
            ..Self::default()
        }
    }
}
