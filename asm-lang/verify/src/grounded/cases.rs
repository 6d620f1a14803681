//! Nodes of grounded states: one for each combination of the inputs that conditions read.

use super::layout::{WordLayout, Words};
use super::run::StoppedRun;
use super::steps::DecidedNumbers;
use crate::decisions::{Decisions, InputValue, MAX_EXECUTIONS};
use crate::explore::{Conditions, Exploration, ExplorationError};
use asmotion_ground::{FAULT, GroundProgram, GroundTerm, UNDEF, evaluate};
use std::collections::HashMap;

/// Inputs, with their numbers.
pub(crate) type InputNumbers = Vec<(u32, i64)>;

/// The combinations of inputs that conditions read.
#[derive(Debug, Default)]
pub(crate) struct InputCases {
    /// The inputs of each combination, as in [`Exploration::inputs`].
    pub numbers: Vec<InputNumbers>,
    known: HashMap<InputNumbers, u32>,
}

impl InputCases {
    /// Adds the nodes of a new state: evaluates the conditions in it with all combinations of the inputs that they read.
    pub fn observe<const W: usize>(
        &mut self,
        (program, layout): (&GroundProgram, &WordLayout),
        (terms, conditions): (&[GroundTerm], &Conditions),
        (number, state): (u32, &Words<W>),
        parent: Option<u32>,
        found: &mut Exploration,
    ) -> Result<(), StoppedRun> {
        let mut numbers = Vec::new();
        layout.decode(state, &mut numbers);
        found.first_nodes.push(found.nodes());
        let decisions = Decisions::default();
        let mut read = Vec::new();
        let mut combinations = 0;
        loop {
            combinations += 1;
            if combinations > MAX_EXECUTIONS {
                return Err(StoppedRun::Error(ExplorationError::Alternatives));
            }
            read.clear();
            let mut valuation = DecidedNumbers {
                program,
                decisions: &decisions,
                read: &mut read,
            };
            let values = terms.iter();
            let values = values.map(|term| evaluate(term, &numbers, &mut valuation));
            let values: Vec<i64> = values.collect();
            if values.contains(&FAULT) {
                // a machine knows the reason
                return Err(StoppedRun::NotGrounded);
            }
            let mut assumed = conditions.assumed.iter();
            if assumed.all(|index| values.get(*index) == Some(&1)) {
                let all = found.truths.iter_mut().zip(&mut found.undefined);
                for ((truths, undefined), value) in all.zip(&values) {
                    truths.push(*value == 1);
                    *undefined += u64::from(*value == UNDEF);
                }
                let inputs = self.inputs_number(program, &read, found);
                found.state_of.push(number);
                found.inputs_of.push(inputs);
                found.parents.push(parent);
            } else {
                found.excluded += 1;
            }
            if !decisions.advance() {
                return Ok(());
            }
        }
    }

    fn inputs_number(
        &mut self,
        program: &GroundProgram,
        read: &InputNumbers,
        found: &mut Exploration,
    ) -> u32 {
        if let Some(number) = self.known.get(read) {
            return *number;
        }
        let values = read.iter().filter_map(|(input, number)| {
            let declared = program.inputs.get(*input as usize)?;
            Some(InputValue {
                machine: 0,
                function: declared.function,
                arguments: declared.arguments.clone().into(),
                value: declared.sort.value(*number),
            })
        });
        let number = found.add_inputs(values.collect());
        self.numbers.push(read.clone());
        self.known.insert(read.clone(), number);
        number
    }
}
