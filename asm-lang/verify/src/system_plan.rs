//! Data that do not change during the exploration of a system.

use crate::inputs::InputRanges;
use crate::mail::MessagePlan;
use crate::preparation::report_of;
use crate::regions::{RepresentedInput, represent};
use crate::system::{InputSource, InputSources, MachineSchedule, VerifiedMachine};
use asmotion_diagnostics::Finding;
use asmotion_lang::ir::FunctionId;
use asmotion_lang::simulate::Script;
use asmotion_lang::{Machine, Report, Value};

/// Data that do not change during an exploration.
#[derive(Debug, Default)]
pub(crate) struct SystemPlan {
    /// Values of the inputs of each machine.
    pub ranges: Vec<InputRanges>,
    pub sources: InputSources,
    pub schedule: MachineSchedule,
    /// The machine that plays the environment.
    pub environment: Option<usize>,
    /// The machine in which terms about several machines are evaluated; it makes no steps.
    pub observer: Option<usize>,
    /// Greatest number of inputs that change in a step, if inputs keep their values.
    pub changes: Option<u32>,
    pub script: Option<Script>,
    pub messages: MessagePlan,
    /// Names of the machines.
    pub names: Vec<String>,
}

impl SystemPlan {
    /// Returns `true` if there are only inputs that have any value in each step.
    pub fn is_plain(&self) -> bool {
        self.environment.is_none()
            && self.changes.is_none()
            && self.script.is_none()
            && !self.messages.is_used()
    }

    /// Gives ranges to the inputs without a finite domain that are only compared with few values.
    ///
    /// # Errors
    /// An input needs values that cannot be enumerated: the index of the machine, and a report.
    pub fn represent_inputs(
        &mut self,
        known: &[VerifiedMachine],
        machines: &[Machine],
    ) -> Result<Vec<RepresentedInput>, (usize, Report)> {
        let mut all = Vec::new();
        if self.script.is_some() {
            // the script has the values
            return Ok(all);
        }
        let are_kept = self.changes.is_some();
        let pairs = known.iter().zip(machines).zip(&mut self.ranges);
        for (index, ((known, machine), ranges)) in pairs.enumerate() {
            let sources = self.sources.get(index);
            let provided = sources.into_iter().flat_map(|it| it.keys().copied());
            let represented = represent(
                index,
                machine,
                &known.specification,
                &provided.collect(),
                are_kept,
                ranges,
            );
            all.extend(represented.map_err(|it| (index, report_of(it.diagnostic())))?);
        }
        Ok(all)
    }

    /// Returns the machines that the schedule selects from.
    pub fn scheduled(&self) -> Vec<usize> {
        let all = 0..self.ranges.len();
        all.filter(|index| ![self.environment, self.observer].contains(&Some(*index)))
            .collect()
    }

    /// Returns where an input location comes from, and the arguments there.
    pub fn source<'s>(
        &'s self,
        machine: usize,
        function: FunctionId,
        arguments: &[Value],
    ) -> Option<&'s InputSource> {
        let sources = self.sources.get(machine)?.get(&function)?;
        sources
            .iter()
            .find(|it| it.arguments.as_deref().is_none_or(|it| it == arguments))
    }
}
