//! Reports about steps of the coordinator that wrote something.

use asmotion_datum::Datum;
use asmotion_lang::Specification;
use asmotion_lang::machine::{Machine, Step};
use asmotion_lang::simulate;
use asmotion_lang::value::Value;
use serde::{Deserialize, Serialize};

/// Kind of the report that contains a [`StepRecord`].
pub const STEP_REPORT: &str = "asm/Step";

/// Kind of the report about a step of which nobody uses the [`STEP_REPORT`]. If the step changed a control state (a location of a
/// function with a [usual name](crate::CONTROL_STATES)), or wrote one for the first time, it is the same [`StepRecord`];
/// otherwise it is the number of the step alone.
///
/// It spares the text of most steps: for observers that count steps and follow control states.
pub const BRIEF_STEP_REPORT: &str = "asm/BriefStep";

/// Kind of the report about a step that failed: a [`StepRecord`] with the inputs that it read and the choices that it
/// made until then, and without updates.
pub const FAILED_STEP_REPORT: &str = "asm/FailedStep";

/// A step in the form of text and numbers, for observers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepRecord {
    /// Name of the specification.
    pub specification: String,
    /// Number of the step, from 1.
    pub number: u64,
    /// Monitored locations that were read, with their values, in order.
    pub inputs: Vec<(String, String)>,
    /// For each choice, the index of the chosen candidate and the number of candidates, in order.
    pub choices: Vec<(u64, u64)>,
    /// The update set, ordered by location.
    pub updates: Vec<UpdateRecord>,
    /// The safe rule, if it made the step in place of the main rule.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub safe_rule: Option<String>,
}

/// An update.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct UpdateRecord {
    /// The updated location as text.
    pub location: String,
    /// Value before the step.
    pub before: String,
    /// Value after the step.
    pub after: String,
    /// Place of the update rule, as in `navigate.asm:42`.
    pub place: String,
}

impl StepRecord {
    /// Reads a report about a step; `None` if it is brief and contains the number of the step alone.
    pub fn of_report(data: &Datum) -> Option<Self> {
        matches!(data, Datum::Record(_))
            .then(|| data.to().ok())
            .flatten()
    }

    /// The record of the step with this number, which has just failed.
    pub fn failed(specification: &Specification, machine: &Machine, number: u64) -> Self {
        let record = Self::of(specification, machine, &machine.last_step());
        Self {
            number,
            updates: Vec::new(),
            ..record
        }
    }

    /// The record of a step that was just made.
    pub fn of(specification: &Specification, machine: &Machine, step: &Step<'_>) -> Self {
        let naming = machine.naming();
        let show = |value: &Value| value.show(&naming).to_string();
        let inputs = step.inputs().iter();
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
            updates: update_records(specification, machine, step),
            safe_rule: None,
        }
    }
}

/// The update set of a step that was just made, ordered by location.
pub(crate) fn update_records(
    specification: &Specification,
    machine: &Machine,
    step: &Step<'_>,
) -> Vec<UpdateRecord> {
    let naming = machine.naming();
    let show = |value: &Value| value.show(&naming).to_string();
    let updates = step.updates().iter().zip(step.before());
    let records = updates.map(|(update, before)| UpdateRecord {
        location: simulate::location(machine, update.slot),
        before: show(before),
        after: show(&update.value),
        place: specification.place(update.origin),
    });
    let mut records: Vec<_> = records.collect();
    records.sort_by(|one, other| one.location.cmp(&other.location));
    records
}
