//! Explanations of failed steps, and accounts of successful ones.
//!
//! A step records nothing about its evaluation, for speed. A step that fails is therefore repeated
//! from its initial state, with the same inputs and choices, by code that records every read and
//! every rule.

use crate::choose::Chooser;
use crate::environment::Environment;
use crate::fault::{FaultKind, StepFault};
use crate::machine::Machine;
use crate::record::StepChoice;
use crate::run::code::CompiledProgram;
use crate::witness_notes::{StepAccount, Witness, WitnessNotes};
use asmotion_ir::{FunctionId, Origin, Program};
use asmotion_value::Value;
use std::collections::BTreeMap;
use std::sync::Arc;

impl Witness {
    /// Explains why the initial state of a program could not be computed.
    pub fn initially(program: &Arc<Program>, fault: &StepFault) -> Option<Self> {
        let mut again = Machine::uninitialised(program.clone(), CompiledProgram::watched(program));
        again.watch(WitnessNotes::for_fault(fault));
        let failed = again.initialise().err();
        again.take_witness(fault, failed)
    }
}

impl Machine {
    /// Explains the fault of the step that has just failed; `None` if it cannot be reproduced.
    pub fn witness(&self, fault: &StepFault) -> Option<Witness> {
        if matches!(
            fault.kind,
            FaultKind::ManyCalls(_) | FaultKind::NoInputs { .. }
        ) {
            // would take as long as the step itself, or longer; there was no step
            return None;
        }
        let last = self.last_step();
        let mut inputs = self.inputs_again();
        if let FaultKind::Input { slot, reason } = &fault.kind {
            let location = self.state().location(self.program(), *slot);
            inputs.refused = location.map(|at| (at, reason.clone()));
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
        let mut choices = self.choices_again();
        let mut again = self.recompiled(CompiledProgram::watched(self.program()));
        again.watch(WitnessNotes::for_fault(fault));
        let done = fault.step > 0 && fault.step == last.number();
        let failed = if done {
            // the step itself succeeded, but its new state violates an invariant
            again
                .recheck(&mut inputs, &mut choices, last.now_ns())
                .err()
        } else {
            again.step(&mut inputs, &mut choices, last.now_ns()).err()
        };
        again.take_witness(fault, failed)
    }

    /// Returns how the last step came to its updates. `before` is the machine before that step. `None` if the step failed or
    /// cannot be repeated.
    pub fn account(&self, before: &Self) -> Option<StepAccount> {
        let mut inputs = self.inputs_again();
        let mut choices = self.choices_again();
        let mut again = before.recompiled(CompiledProgram::watched(before.program()));
        again.watch(WitnessNotes::for_step());
        let now_ns = self.last_step().now_ns();
        again.step(&mut inputs, &mut choices, now_ns).ok()?;
        let is_same = again.last_step().updates() == self.last_step().updates();
        let notes = again.notes().filter(|_| is_same)?;
        Some(notes.into_account())
    }

    /// Returns the inputs of the last step.
    fn inputs_again(&self) -> ReplayInputs {
        let last = self.last_step();
        let inputs = last.inputs().iter().filter_map(|input| {
            let location = self.state().location(self.program(), input.slot)?;
            Some((location, input.value.clone()))
        });
        ReplayInputs {
            known: inputs.collect(),
            refused: None,
            source: String::new(),
        }
    }

    /// Returns the choices of the last step.
    fn choices_again(&self) -> ReplayChoices<'_> {
        ReplayChoices {
            choices: self.last_step().choices(),
            picked: self.picked(),
            next: 0,
        }
    }

    /// Returns the records if the repetition ended with the same fault, or in the same endless
    /// loop.
    fn take_witness(
        &mut self,
        fault: &StepFault,
        again: Option<Box<StepFault>>,
    ) -> Option<Witness> {
        let (notes, again) = (self.notes()?, again?);
        let is_it = match (&again.kind, &fault.kind) {
            (FaultKind::Endless(_), FaultKind::Endless(_)) => again.origin == fault.origin,
            _ => *again == *fault,
        };
        is_it.then(|| notes.into_witness())
    }
}

/// Replays the recorded inputs.
struct ReplayInputs {
    known: BTreeMap<(FunctionId, Vec<Value>), Value>,
    /// The location whose input the environment refused, and its error.
    refused: Option<((FunctionId, Vec<Value>), String)>,
    /// Source of a rejected input value.
    source: String,
}

impl Environment for ReplayInputs {
    fn read(&mut self, function: FunctionId, arguments: &[Value]) -> Result<Option<Value>, String> {
        let location = (function, arguments.to_vec());
        match &self.refused {
            Some((refused, reason)) if *refused == location => Err(reason.clone()),
            Some(_) | None => Ok(self.known.get(&location).cloned()),
        }
    }

    fn source(&self, _function: FunctionId, _arguments: &[Value]) -> String {
        self.source.clone()
    }
}

/// Replays the recorded choices.
struct ReplayChoices<'a> {
    choices: &'a [StepChoice],
    picked: &'a [(Origin, Value)],
    next: usize,
}

impl Chooser for ReplayChoices<'_> {
    fn choose(&mut self, _count: usize) -> usize {
        let choice = self.choices.get(self.next);
        self.next += 1;
        choice.map_or(0, |choice| choice.index)
    }

    fn takes_first(&self) -> bool {
        self.choices.is_empty()
    }

    fn picked(&self, range: Origin) -> Option<Value> {
        let picked = self.picked.iter().find(|(known, _)| *known == range);
        picked.map(|(_, value)| value.clone())
    }
}
