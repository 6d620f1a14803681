//! What a failed step saw.
//!
//! A step keeps no notes, so that it is fast. Where one fails, it is done once more: on the state it
//! began in, with the inputs and choices it had, by code in which every read and every rule is
//! watched.

use crate::choose::Chooser;
use crate::code::CompiledProgram;
use crate::environment::Environment;
use crate::fault::{FaultKind, StepFault};
use crate::machine::Machine;
use crate::notes::Witness;
use crate::record::StepChoice;
use asmotion_ir::{FunctionId, Origin, Program};
use asmotion_value::Value;
use std::collections::BTreeMap;
use std::sync::Arc;

impl Witness {
    /// What a machine saw that could not be built.
    pub fn initially(program: &Arc<Program>, fault: &StepFault) -> Option<Self> {
        let mut again = Machine::blank(program.clone(), CompiledProgram::watched(program));
        again.watch(fault);
        let failed = again.initialise().err();
        again.told(fault, failed)
    }
}

impl Machine {
    /// What the step saw that failed just now.
    pub fn witness(&self, fault: &StepFault) -> Option<Witness> {
        if matches!(fault.kind, FaultKind::ManyCalls(_)) {
            // it would take that long once more, and longer
            return None;
        }
        let last = self.last_step();
        let inputs = last.inputs().iter().filter_map(|input| {
            let location = self.state().location(self.program(), input.slot)?;
            Some((location, input.value.clone()))
        });
        let mut inputs = ReplayInputs {
            known: inputs.collect(),
            refused: String::new(),
            source: String::new(),
        };
        if let FaultKind::Input { reason, .. } = &fault.kind {
            inputs.refused.clone_from(reason);
        }
        if let FaultKind::OutsideInput {
            slot,
            misfit,
            source,
        } = &fault.kind
        {
            let location = self.state().location(self.program(), *slot);
            let value = misfit.value.clone();
            inputs.known.extend(location.map(|at| (at, value)));
            inputs.source.clone_from(source);
        }
        let mut choices = ReplayChoices {
            made: last.choices(),
            picked: self.picked(),
            next: 0,
        };
        let mut again = self.recompiled(CompiledProgram::watched(self.program()));
        again.watch(fault);
        let done = fault.step > 0 && fault.step == last.number();
        let failed = match done {
            // the step was done, and its new state violates an invariant
            true => again
                .check_again(&mut inputs, &mut choices, last.now_ns())
                .err(),
            false => again.step(&mut inputs, &mut choices, last.now_ns()).err(),
        };
        again.told(fault, failed)
    }

    /// The witness, if it was the same fault; of a loop without end, the same loop.
    fn told(&mut self, fault: &StepFault, again: Option<Box<StepFault>>) -> Option<Witness> {
        let (notes, again) = (self.notes()?, again?);
        let is_it = match (&again.kind, &fault.kind) {
            (FaultKind::Endless(_), FaultKind::Endless(_)) => again.origin == fault.origin,
            _ => *again == *fault,
        };
        is_it.then(|| notes.into_witness())
    }
}

/// Answers as the environment did.
struct ReplayInputs {
    known: BTreeMap<(FunctionId, Vec<Value>), Value>,
    /// Why there was no answer, if there was none.
    refused: String,
    /// Who gave a value that is none of its location's.
    source: String,
}

impl Environment for ReplayInputs {
    fn read(&mut self, function: FunctionId, arguments: &[Value]) -> Result<Option<Value>, String> {
        match self.known.get(&(function, arguments.to_vec())) {
            Some(value) => Ok(Some(value.clone())),
            None if self.refused.is_empty() => Ok(None),
            None => Err(self.refused.clone()),
        }
    }

    fn source(&self, _function: FunctionId, _arguments: &[Value]) -> String {
        self.source.clone()
    }
}

/// Chooses as it was chosen.
struct ReplayChoices<'a> {
    made: &'a [StepChoice],
    picked: &'a [(Origin, Value)],
    next: usize,
}

impl Chooser for ReplayChoices<'_> {
    fn choose(&mut self, _count: usize) -> usize {
        let choice = self.made.get(self.next);
        self.next += 1;
        choice.map_or(0, |choice| choice.index)
    }

    fn takes_first(&self) -> bool {
        self.made.is_empty()
    }

    fn picked(&self, range: Origin) -> Option<Value> {
        let picked = self.picked.iter().find(|(known, _)| *known == range);
        picked.map(|(_, value)| value.clone())
    }
}
