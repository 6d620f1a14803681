//! Steps and conditions that a machine executes in a state given by words.

use super::layout::{WordLayout, Words};
use crate::decisions::{
    DecidedChoices, DecidedInputs, Decision, Decisions, InputValue, MAX_EXECUTIONS,
};

use crate::inputs::InputRanges;
use crate::transition::MachineFault;
use asmotion_ground::{GroundProgram, Sort};
use asmotion_lang::hir::AddedTerm;
use asmotion_lang::{Machine, Value};

/// Returns the words of the state in which a machine is; `None` if they cannot express it.
pub(crate) fn words_of<const W: usize>(
    program: &GroundProgram,
    layout: &WordLayout,
    machine: &Machine,
) -> Option<Words<W>> {
    let slots = machine.slots();
    let mut state = [0; W];
    for (variable, field) in program.variables.iter().zip(&layout.fields) {
        let value = slots.get(variable.slot as usize)?;
        let (sort, number) = Sort::number(value)?;
        if sort.is_some_and(|sort| sort != variable.sort) {
            return None;
        }
        field.set(&mut state, field.code(number)?);
    }
    Some(state)
}

/// The steps of a state, found by a machine.
#[derive(Debug)]
pub(crate) struct MachineSteps<const W: usize> {
    /// The next states, in order, and whether the step updates a location.
    pub next: Vec<(Words<W>, bool)>,
    pub faults: Vec<(Vec<Decision>, MachineFault)>,
}

/// The reason for which a machine's steps do not lead to states in words.
#[derive(Debug)]
pub(crate) enum NotWords {
    /// There are too many executions.
    Alternatives,
    /// A step changes more than the variables.
    Elsewhere,
    /// The layout has no code for a number of this variable.
    Wider(u32, i64),
}

/// A machine that is set to states given by words.
pub(crate) struct WordMachine<'a> {
    pub machine: Machine,
    pub ranges: &'a InputRanges,
    decisions: Decisions,
}

impl<'a> WordMachine<'a> {
    pub fn new(machine: &Machine, ranges: &'a InputRanges) -> Self {
        Self {
            machine: machine.clone(),
            ranges,
            decisions: Decisions::default(),
        }
    }

    /// Sets the machine to a state.
    pub fn enter<const W: usize>(
        &mut self,
        program: &GroundProgram,
        layout: &WordLayout,
        state: &Words<W>,
    ) {
        let slots = self.machine.slots_mut();
        for (variable, field) in program.variables.iter().zip(&layout.fields) {
            if let Some(slot) = slots.get_mut(variable.slot as usize) {
                *slot = variable.sort.value(field.number(field.get(state)));
            }
        }
    }

    /// Executes all steps in a state.
    pub fn steps<const W: usize>(
        &mut self,
        program: &GroundProgram,
        layout: &WordLayout,
        state: &Words<W>,
        known: &[InputValue],
    ) -> Result<MachineSteps<W>, NotWords> {
        self.enter(program, layout, state);
        self.decisions.restart();
        let mut found = MachineSteps {
            next: Vec::new(),
            faults: Vec::new(),
        };
        let mut executions = 0;
        loop {
            executions += 1;
            if executions > MAX_EXECUTIONS {
                return Err(NotWords::Alternatives);
            }
            let mut inputs = DecidedInputs {
                machine: 0,
                decisions: &self.decisions,
                ranges: self.ranges,
                known,
            };
            let mut choices = DecidedChoices(&self.decisions);
            match self.machine.evaluate_step(&mut inputs, &mut choices, 0) {
                Ok(updates) => {
                    let mut next = *state;
                    for update in updates {
                        let known = program
                            .variables
                            .binary_search_by_key(&update.slot, |variable| variable.slot);
                        let Ok(index) = known else {
                            return Err(NotWords::Elsewhere);
                        };
                        let (Some(variable), Some(field)) =
                            (program.variables.get(index), layout.fields.get(index))
                        else {
                            return Err(NotWords::Elsewhere);
                        };
                        let number = match Sort::number(&update.value) {
                            Some((sort, number))
                                if sort.is_none_or(|sort| sort == variable.sort) =>
                            {
                                number
                            }
                            Some(_) | None => return Err(NotWords::Elsewhere),
                        };
                        let code = field.code(number);
                        let code = code.ok_or(NotWords::Wider(index as u32, number))?;
                        field.set(&mut next, code);
                    }
                    let has_updates = !updates.is_empty();
                    if !self.machine.last_step().extended().is_empty() {
                        return Err(NotWords::Elsewhere);
                    }
                    found.next.push((next, has_updates));
                }
                Err(fault) => {
                    let fault = MachineFault::of_step(0, fault);
                    found.faults.push((self.decisions.taken(), fault));
                }
            }
            if !self.decisions.advance() {
                return Ok(found);
            }
        }
    }

    /// Evaluates a condition in a state. `None` if it depends on inputs.
    pub fn condition<const W: usize>(
        &mut self,
        program: &GroundProgram,
        layout: &WordLayout,
        state: &Words<W>,
        term: AddedTerm,
    ) -> Option<Result<Value, MachineFault>> {
        self.enter(program, layout, state);
        self.decisions.restart();
        let mut inputs = DecidedInputs {
            machine: 0,
            decisions: &self.decisions,
            ranges: self.ranges,
            known: &[],
        };
        let mut values = Vec::new();
        let done = self
            .machine
            .evaluate_each(&[term], &mut inputs, 0, &mut values);
        if !self.decisions.read().is_empty() {
            return None;
        }
        Some(match done {
            Ok(()) => Ok(values.pop().unwrap_or_default()),
            Err((_, fault)) => Err(MachineFault::of_step(0, fault)),
        })
    }
}
