//! The inputs of a machine of a system.

use crate::decisions::{Decisions, InputValue};
use crate::system::InputSource;
use crate::system_plan::SystemPlan;
use crate::translation::translated;
use asmotion_lang::ir::{FunctionId, FunctionKind, Program};
use asmotion_lang::{Environment, Machine, Value};
use std::borrow::Cow;
use std::sync::Arc;

/// The machines other than the one that makes a step.
#[derive(Clone, Copy)]
pub(crate) struct OtherMachines<'a> {
    pub before: &'a [Machine],
    pub after: &'a [Machine],
    /// Machines that have made their step in this transition, of which the values before it are read.
    pub moved: &'a [usize],
}

impl OtherMachines<'_> {
    fn machine(&self, index: usize) -> Option<&Machine> {
        let rest = index.checked_sub(self.before.len() + 1);
        let after = rest.and_then(|rest| self.after.get(rest));
        self.before.get(index).or(after)
    }

    fn value(&self, index: usize, function: FunctionId, arguments: &[Value]) -> Option<Value> {
        let machine = self.machine(index)?;
        Some(if self.moved.contains(&index) {
            machine.value_before(function, arguments)
        } else {
            machine.value_at(function, arguments)
        })
    }
}

/// The inputs of a machine of a system: read from other machines, from a script, or decided.
pub(crate) struct SystemInputs<'a> {
    pub machine: usize,
    pub plan: &'a SystemPlan,
    pub decisions: &'a Decisions,
    pub known: &'a [InputValue],
    pub held: &'a [InputValue],
    pub scripted: usize,
    pub others: OtherMachines<'a>,
    pub own_program: Arc<Program>,
}

impl SystemInputs<'_> {
    /// Returns the value of an input that another machine provides.
    fn provided(
        &self,
        source: &InputSource,
        function: FunctionId,
        arguments: &[Value],
    ) -> Result<Value, String> {
        let missing = || "the machine that provides it does not exist".to_owned();
        let machine = self.others.machine(source.machine).ok_or_else(missing)?;
        let own = &self.own_program;
        let there = match &source.source_arguments {
            Some(arguments) => Cow::Borrowed(arguments.as_slice()),
            None => {
                let provider = machine.program();
                let declared = provider.functions.get(source.function.0 as usize);
                let shapes = declared.map(|it| it.parameters.as_slice());
                let pairs = arguments.iter().zip(shapes.unwrap_or_default());
                let there = pairs.map(|(value, shape)| translated(value, own, provider, shape));
                // an argument without a counterpart there denotes no location, so there is no value
                let Some(there) = there.collect::<Option<Vec<Value>>>() else {
                    return Ok(Value::Undef);
                };
                Cow::Owned(there)
            }
        };
        let provider = machine.program();
        let provided = provider.functions.get(source.function.0 as usize);
        let value = if provided.is_some_and(|it| it.kind == FunctionKind::Monitored) {
            // the observer reads an input of a machine as the machine does
            let mut inputs = SystemInputs {
                machine: source.machine,
                own_program: provider.clone(),
                ..*self
            };
            inputs.read(source.function, &there)?.ok_or_else(missing)?
        } else {
            let value = self.others.value(source.machine, source.function, &there);
            value.ok_or_else(missing)?
        };
        let declared = own.functions.get(function.0 as usize);
        let shape = declared.map(|it| &it.codomain).ok_or_else(missing)?;
        translated(&value, machine.program(), own, shape).ok_or_else(|| {
            let name = self.plan.names.get(source.machine);
            let name = name.map_or("", |name| name.as_str());
            let value = value.show(&machine.naming()).to_string();
            format!("`{name}` provides `{value}`, which this specification does not have")
        })
    }

    /// Returns the number of inputs whose values differ from those that are held.
    fn changes(&self) -> u32 {
        let read = self.decisions.read();
        let differs = |input: &&InputValue| {
            let held = find(self.held, input.machine, input.function, &input.arguments);
            held.is_some_and(|held| held.value != input.value)
        };
        let changed = self.known.iter().chain(&read).filter(differs);
        u32::try_from(changed.count()).unwrap_or(u32::MAX)
    }
}

fn find<'i>(
    inputs: &'i [InputValue],
    machine: usize,
    function: FunctionId,
    arguments: &[Value],
) -> Option<&'i InputValue> {
    inputs
        .iter()
        .find(|it| it.machine == machine && it.function == function && *it.arguments == *arguments)
}

impl Environment for SystemInputs<'_> {
    fn read(&mut self, function: FunctionId, arguments: &[Value]) -> Result<Option<Value>, String> {
        if let Some(source) = self.plan.source(self.machine, function, arguments) {
            return self.provided(source, function, arguments).map(Some);
        }
        let declared = self.own_program.functions.get(function.0 as usize);
        if declared.is_some_and(|it| it.mail.is_some()) {
            return Ok(None);
        }
        if let Some(script) = &self.plan.script
            && Some(self.machine) != self.plan.environment
        {
            let mut script = script.clone();
            script.go_to(self.scripted);
            let read = script.read(function, arguments);
            // the run has ended: nothing is known of its next inputs
            return if self.scripted >= script.len() {
                Ok(read.unwrap_or(Some(Value::Undef)))
            } else {
                read
            };
        }
        if let Some(known) = find(self.known, self.machine, function, arguments) {
            return Ok(Some(known.value.clone()));
        }
        let values = self.plan.ranges.get(self.machine);
        let Some(values) = values else {
            return Ok(None);
        };
        let values = values.of(function)?;
        if let (Some(changes), Some(held)) = (
            self.plan.changes,
            find(self.held, self.machine, function, arguments),
        ) && !self.decisions.has_read(self.machine, function, arguments)
            && self.changes() >= changes
        {
            let kept = std::slice::from_ref(&held.value);
            return Ok(Some(self.decisions.input(
                self.machine,
                function,
                arguments,
                kept,
            )));
        }
        Ok(Some(self.decisions.input(
            self.machine,
            function,
            arguments,
            values,
        )))
    }

    fn source(&self, function: FunctionId, arguments: &[Value]) -> String {
        if let Some(source) = self.plan.source(self.machine, function, arguments)
            && let Some(name) = self.plan.names.get(source.machine)
        {
            return format!("`{name}`");
        }
        match &self.plan.script {
            Some(script) => {
                let mut script = script.clone();
                script.go_to(self.scripted);
                script.source(function, arguments)
            }
            None => "the verifier".to_owned(),
        }
    }
}
