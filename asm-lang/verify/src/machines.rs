//! Systems of several machines, with an environment and messages, as transition systems.
//!
//! A transition is a step of the machines that the schedule selects, and then one of the environment, if it is a specification: it
//! prepares the inputs of the next transition. A state is therefore observed between the environment's step and the system's: with the
//! inputs that the system reads next.

use crate::decisions::{DecidedChoices, Decisions, InputValue};
use crate::delivery::{Arrivals, Delivery};
use crate::inputs::InputRanges;
use crate::mail::MessagePlan;
use crate::post::{ByteReader, Post, write_number};
use crate::system::{InputSource, InputSources, MachineSchedule};
use crate::transition::{ConditionTerm, FairLabels, MachineFault, TransitionSystem};
use crate::translation::translated;
use asmotion_lang::hir::AddedTerm;
use asmotion_lang::ir::FunctionId;
use asmotion_lang::machine::pack_value;
use asmotion_lang::simulate::Script;
use asmotion_lang::{Environment, Machine, Value};
use std::borrow::Cow;

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
    fn source<'s>(
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

/// Machines in a state of the system.
#[derive(Clone)]
pub(crate) struct MachineSystem<'a> {
    plan: &'a SystemPlan,
    machines: Vec<Machine>,
    /// Inputs that the last step read, sorted by location, if inputs keep their values.
    held: Vec<InputValue>,
    /// Number of steps of the script that are done.
    scripted: usize,
    post: Post,
    moved: Vec<usize>,
    /// Label of the last step.
    label: u32,
    /// What happened to messages in the last step.
    events: Vec<String>,
}

impl<'a> MachineSystem<'a> {
    /// Creates the system in its initial state.
    pub fn new(plan: &'a SystemPlan, mut machines: Vec<Machine>) -> Self {
        for (machine, mail) in machines.iter_mut().zip(&plan.messages.machines) {
            machine.set_partners(mail.partners.clone());
        }
        Self {
            plan,
            machines,
            held: Vec::new(),
            scripted: 0,
            post: Post::default(),
            moved: Vec::new(),
            label: 0,
            events: Vec::new(),
        }
    }

    /// Moves one machine: messages arrive, the machine makes a step, and its messages leave. Returns `true` if something changed.
    fn advance_machine(
        &mut self,
        index: usize,
        decisions: &Decisions,
        known: &[InputValue],
    ) -> Result<bool, MachineFault> {
        let uses_messages = self.plan.messages.is_used();
        let mut has_changed = false;
        if uses_messages {
            let arrivals = self.delivery(decisions).arrive(index);
            has_changed |= arrivals.is_any;
            self.label |= arrivals.label;
        }
        self.moved.push(index);
        let (before, rest) = self.machines.split_at_mut(index);
        let Some((machine, after)) = rest.split_first_mut() else {
            return Ok(false);
        };
        let mut inputs = SystemInputs {
            machine: index,
            plan: self.plan,
            decisions,
            known,
            held: &self.held,
            scripted: self.scripted,
            others: Others {
                before,
                after,
                moved: match self.plan.schedule {
                    MachineSchedule::Synchronous if Some(index) != self.plan.environment => {
                        &self.moved
                    }
                    MachineSchedule::Synchronous | MachineSchedule::Interleaved => &[],
                },
            },
            own_program: machine.program().clone(),
        };
        let mut choices = DecidedChoices(decisions);
        match machine.step(&mut inputs, &mut choices, 0) {
            Ok(step) => has_changed |= !step.updates().is_empty(),
            Err(fault) => {
                return Err(MachineFault::of_step(index, fault));
            }
        }
        if uses_messages {
            has_changed |= self.delivery(decisions).send(index)?;
        }
        Ok(has_changed)
    }

    fn delivery<'s>(&'s mut self, decisions: &'s Decisions) -> Delivery<'s> {
        Delivery {
            plan: &self.plan.messages,
            names: &self.plan.names,
            machines: &mut self.machines,
            post: &mut self.post,
            decisions,
            events: &mut self.events,
        }
    }

    /// Keeps the inputs that the transition read, if inputs keep their values.
    fn hold(&mut self, decisions: &Decisions, known: &[InputValue]) {
        if self.plan.changes.is_none() {
            return;
        }
        let moved = &self.moved;
        self.held.retain(|input| !moved.contains(&input.machine));
        for input in known.iter().cloned().chain(decisions.read()) {
            let is_it = |held: &InputValue| {
                (held.machine, held.function, &held.arguments)
                    == (input.machine, input.function, &input.arguments)
            };
            self.held.retain(|held| !is_it(held));
            self.held.push(input);
        }
        self.held.sort_by(|left, right| {
            let key = |input: &InputValue| (input.machine, input.function);
            key(left)
                .cmp(&key(right))
                .then_with(|| left.arguments.cmp(&right.arguments))
        });
    }

    /// Brings the state into a form that does not depend on its history.
    fn settle(&mut self) {
        if !self.plan.messages.is_used() {
            return;
        }
        for (index, mail) in self.plan.messages.machines.iter().enumerate() {
            if let Some(machine) = self.machines.get_mut(index)
                && mail.is_used
            {
                let known = machine.renumber_messages(&|operation| mail.is_answered(operation));
                self.post.renumber(index, &known);
            }
        }
    }

    fn restore_all(&mut self, state: &[u8]) -> Option<()> {
        let mut from = ByteReader(state);
        for machine in &mut self.machines {
            machine.restore_state(from.block()?).ok()?;
        }
        if self.plan.changes.is_some() {
            self.held.clear();
            for _ in 0..from.number()? {
                let index = from.index()?;
                let machine = self.machines.get(index)?;
                let function = FunctionId(u32::try_from(from.number()?).ok()?);
                let count = from.index()?;
                let arguments = (0..count).map(|_| from.value(machine));
                let arguments = arguments.collect::<Option<Vec<Value>>>()?;
                self.held.push(InputValue {
                    machine: index,
                    function,
                    arguments: arguments.into(),
                    value: from.value(machine)?,
                });
            }
        }
        if self.plan.script.is_some() {
            self.scripted = from.index()?;
        }
        if self.plan.messages.is_used() {
            self.post = Post::unpack(&mut from, &self.machines)?;
        }
        Some(())
    }
}

impl TransitionSystem for MachineSystem<'_> {
    fn begin(&mut self, decisions: &Decisions) -> Result<(), MachineFault> {
        self.moved.clear();
        self.events.clear();
        if let Some(environment) = self.plan.environment {
            self.advance_machine(environment, decisions, &[])?;
        }
        Ok(())
    }

    fn pack(&mut self, to: &mut Vec<u8>) {
        self.settle();
        let mut bytes = Vec::new();
        for machine in &self.machines {
            bytes.clear();
            machine.pack_state(&mut bytes);
            write_number(bytes.len() as u64, to);
            to.extend_from_slice(&bytes);
        }
        if self.plan.changes.is_some() {
            write_number(self.held.len() as u64, to);
            for input in &self.held {
                write_number(input.machine as u64, to);
                write_number(input.function.0.into(), to);
                write_number(input.arguments.len() as u64, to);
                for value in input.arguments.iter().chain([&input.value]) {
                    let bytes = pack_value(value);
                    write_number(bytes.len() as u64, to);
                    to.extend_from_slice(&bytes);
                }
            }
        }
        if self.plan.script.is_some() {
            write_number(self.scripted as u64, to);
        }
        if self.plan.messages.is_used() {
            self.post.pack(&self.machines, to);
        }
    }

    fn restore(&mut self, state: &[u8]) {
        // cannot fail: the bytes are from this system
        let _ = self.restore_all(state);
    }

    fn can_revert(&self) -> bool {
        false
    }

    fn revert(&mut self) {}

    fn has_ended(&self) -> bool {
        let script = self.plan.script.as_ref();
        script.is_some_and(|script| self.scripted >= script.len())
    }

    fn step(&mut self, decisions: &Decisions, known: &[InputValue]) -> Result<bool, MachineFault> {
        self.moved.clear();
        self.events.clear();
        let mut movers = self.plan.scheduled();
        if self.plan.schedule == MachineSchedule::Interleaved && movers.len() > 1 {
            let taken = decisions.decide(movers.len());
            movers = movers.get(taken).copied().into_iter().collect();
        }
        self.label = match movers.as_slice() {
            [only] => *only as u32 & MACHINE,
            _ => 0,
        };
        let mut has_changed = false;
        for index in movers {
            has_changed |= self.advance_machine(index, decisions, known)?;
        }
        self.hold(decisions, known);
        self.scripted += 1;
        if let Some(environment) = self.plan.environment {
            has_changed |= self.advance_machine(environment, decisions, &[])?;
        }
        Ok(has_changed)
    }

    fn evaluate(
        &mut self,
        conditions: &[ConditionTerm],
        decisions: &Decisions,
        values: &mut Vec<Value>,
    ) -> Result<(), MachineFault> {
        for group in conditions.chunk_by(|left, right| left.machine == right.machine) {
            let Some(index) = group.first().map(|it| it.machine) else {
                continue;
            };
            let terms: Vec<AddedTerm> = group.iter().map(|it| it.term).collect();
            let (before, rest) = self.machines.split_at_mut(index);
            let Some((machine, after)) = rest.split_first_mut() else {
                continue;
            };
            let mut inputs = SystemInputs {
                machine: index,
                plan: self.plan,
                decisions,
                known: &[],
                held: &self.held,
                scripted: self.scripted,
                others: Others {
                    before,
                    after,
                    moved: &[],
                },
                own_program: machine.program().clone(),
            };
            let done = machine.evaluate_each(&terms, &mut inputs, 0, values);
            done.map_err(|(_, fault)| MachineFault::of_step(index, fault))?;
        }
        Ok(())
    }

    fn machines(&self) -> &[Machine] {
        &self.machines
    }

    fn moved(&self) -> &[usize] {
        &self.moved
    }

    fn keep_candidates(&mut self) {
        self.machines.iter_mut().for_each(Machine::keep_candidates);
    }

    fn prepares_next(&self, machine: usize) -> bool {
        self.plan.environment == Some(machine)
    }

    fn events(&self) -> &[String] {
        &self.events
    }

    fn label(&self) -> u32 {
        self.label
    }

    fn fairness(&self) -> Vec<FairLabels> {
        let scheduled = self.plan.scheduled();
        let is_interleaved =
            self.plan.schedule == MachineSchedule::Interleaved && scheduled.len() > 1;
        let mut fair = Vec::new();
        for &index in &scheduled {
            let machine = index as u32;
            let (mask, value) = if is_interleaved {
                (MACHINE, machine)
            } else {
                (0, 0)
            };
            // the schedule selects each machine again and again
            if is_interleaved {
                fair.push(FairLabels { mask, value });
            }
            if !self.plan.messages.is_used() {
                continue;
            }
            // calls end at their deadline, and messages arrive
            let senders = 0..self.machines.len();
            let senders = senders.filter(|_| self.plan.messages.model.is_delayed);
            let prompt = senders.map(Arrivals::of_sender);
            for bit in [Arrivals::CALLS].into_iter().chain(prompt) {
                fair.push(FairLabels {
                    mask: mask | bit,
                    value: value | bit,
                });
            }
        }
        fair
    }
}

/// The bits of a label that name the machine that the schedule selected.
const MACHINE: u32 = 0xff;

/// The machines other than the one that makes a step.
struct Others<'a> {
    before: &'a [Machine],
    after: &'a [Machine],
    /// Machines that have made their step in this transition, of which the values before it are read.
    moved: &'a [usize],
}

impl Others<'_> {
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
struct SystemInputs<'a> {
    machine: usize,
    plan: &'a SystemPlan,
    decisions: &'a Decisions,
    known: &'a [InputValue],
    held: &'a [InputValue],
    scripted: usize,
    others: Others<'a>,
    own_program: std::sync::Arc<asmotion_lang::ir::Program>,
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
        let value = self.others.value(source.machine, source.function, &there);
        let value = value.ok_or_else(missing)?;
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
