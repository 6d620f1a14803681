//! What the coordinator tells of its steps: those that wrote something.

use asmotion_lang::Specification;
use asmotion_lang::machine::{Machine, Step};
use asmotion_lang::simulate;
use asmotion_lang::value::Value;
use serde::{Deserialize, Serialize};

/// The kind under which a [`StepRecord`] is reported to observers.
pub const STEP_REPORT: &str = "asm/Step";

/// A step as text and numbers, for observers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepRecord {
    /// The specification.
    pub specification: String,
    /// Its number, from 1.
    pub number: u64,
    /// What was read of the environment, as location and value, in order.
    pub inputs: Vec<(String, String)>,
    /// Which candidate was chosen, and of how many, in order.
    pub choices: Vec<(u64, u64)>,
    /// The update set, by location.
    pub updates: Vec<UpdateRecord>,
}

/// An update.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct UpdateRecord {
    /// The location.
    pub location: String,
    /// What it held.
    pub before: String,
    /// What it holds.
    pub after: String,
}

impl StepRecord {
    /// The record of a step just done.
    pub fn of(specification: &Specification, machine: &Machine, step: &Step<'_>) -> Self {
        let naming = machine.naming();
        let show = |value: &Value| value.show(&naming).to_string();
        let inputs = step.inputs().iter();
        let updates = simulate::updates(machine, step).into_iter();
        Self {
            specification: specification.model.name.to_string(),
            number: step.number(),
            inputs: inputs
                .map(|input| (simulate::location(machine, input.slot), show(&input.value)))
                .collect(),
            choices: step
                .choices()
                .iter()
                .map(|choice| (choice.index as u64, choice.count as u64))
                .collect(),
            updates: updates
                .map(|(location, before, after)| UpdateRecord {
                    location,
                    before,
                    after,
                })
                .collect(),
        }
    }
}
