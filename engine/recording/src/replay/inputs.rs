//! The inputs and choices of a recorded step, for its repetition.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use asmotion_coordinator::{ChoiceRecord, RecordedCycle};
use asmotion_lang::Chooser;
use asmotion_lang::ir::FunctionKind;
use asmotion_lang::machine::Machine;
use asmotion_lang::simulate::{self, InputTexts, RecordedInputs, RecordedStep};

/// The inputs of a machine: records have those that change.
#[derive(Debug, Default)]
pub(super) struct RecordedFrame {
    values: BTreeMap<String, String>,
    /// The same for [`RecordedStep`].
    texts: Arc<InputTexts>,
}

impl RecordedFrame {
    /// Continues with the inputs of a step. A machine that begins gets all of them.
    pub fn advance(&mut self, cycle: &RecordedCycle) {
        if !cycle.begins.is_empty() {
            self.values.clear();
        } else if cycle.frame.is_empty() {
            return;
        }
        for (location, value) in &cycle.frame {
            self.values.insert(location.clone(), value.clone());
        }
        let values = self.values.iter();
        let texts = values.map(|(location, value)| (location.clone(), value.clone()));
        self.texts = Arc::new(texts.collect());
    }

    /// The inputs with their values, ordered by location.
    pub fn values(&self) -> &BTreeMap<String, String> {
        &self.values
    }

    /// The step with these inputs.
    pub fn step(&self, cycle: &RecordedCycle) -> RecordedStep {
        let choices = cycle.choices.iter();
        let choices = choices.map(|choice| usize::try_from(choice.index).unwrap_or(usize::MAX));
        RecordedStep::with_frame(
            cycle.time_ns,
            Arc::clone(&self.texts),
            choices.collect(),
            cycle.messages.clone(),
        )
    }

    /// Monitored locations that the last step has read and that have no recorded value. Functions of time need none.
    pub fn missing(&self, machine: &Machine) -> Vec<String> {
        let program = machine.program();
        let step = machine.last_step();
        let read = step.inputs().iter().filter(|input| {
            let function = machine.state().function(program, input.slot);
            let function = function.and_then(|it| program.functions.get(it.0 as usize));
            function.is_some_and(|it| it.kind == FunctionKind::Monitored && it.clock.is_none())
        });
        let locations = read.map(|input| simulate::location(machine, input.slot));
        locations
            .filter(|location| !self.values.contains_key(location))
            .collect()
    }
}

/// The inputs at a moment at which no step was made.
pub(super) fn inputs_at(
    time_ns: i64,
    frame: &BTreeMap<String, String>,
    machine: &Machine,
) -> RecordedInputs {
    let values = frame.iter();
    let texts = values.map(|(location, value)| (location.clone(), value.clone()));
    let step = RecordedStep::with_frame(time_ns, Arc::new(texts.collect()), Vec::new(), Vec::new());
    // values that do not fit are missing, as they were for the machine
    step.readable_inputs(machine).0
}

/// Makes the recorded choices, and notes where there are others.
#[derive(Debug)]
pub(super) struct RecordedChooser {
    choices: Vec<ChoiceRecord>,
    next: usize,
    /// Descriptions of the choices that the record does not determine.
    pub open: BTreeSet<String>,
}

impl RecordedChooser {
    /// Makes the choices of a step; those of a step that the safe rule replaced come first.
    pub fn new(cycle: &RecordedCycle) -> Self {
        let replaced = cycle.replaced.iter().flat_map(|it| &it.choices);
        Self {
            choices: replaced.chain(&cycle.choices).copied().collect(),
            next: 0,
            open: BTreeSet::new(),
        }
    }
}

impl Chooser for RecordedChooser {
    fn choose(&mut self, count: usize) -> usize {
        let recorded = self.choices.get(self.next);
        self.next += 1;
        let Some(ChoiceRecord { index, of }) = recorded else {
            self.open.insert(format!(
                "a choice among {count} candidates is not recorded: the first one is taken"
            ));
            return 0;
        };
        if usize::try_from(*of) != Ok(count) {
            self.open.insert(format!(
                "a choice among {of} candidates has {count} now: number {} of them is taken",
                (index + 1).min(count as u64)
            ));
        }
        usize::try_from(*index).unwrap_or(usize::MAX)
    }
}
