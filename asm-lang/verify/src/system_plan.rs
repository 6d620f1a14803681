//! What does not change during the exploration of a system.

use crate::inputs::InputRanges;
use crate::mail::MessagePlan;
use crate::system::{InputSource, InputSources, MachineSchedule};
use asmotion_lang::Value;
use asmotion_lang::ir::FunctionId;
use asmotion_lang::simulate::Script;

/// What does not change during an exploration.
#[derive(Debug, Default)]
pub(crate) struct SystemPlan {
    /// Values of the inputs of each machine.
    pub ranges: Vec<InputRanges>,
    pub sources: InputSources,
    pub schedule: MachineSchedule,
    /// The machine that plays the environment.
    pub environment: Option<usize>,
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

    /// Returns the machines that the schedule selects from.
    pub fn scheduled(&self) -> Vec<usize> {
        let all = 0..self.ranges.len();
        all.filter(|index| Some(*index) != self.environment)
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
