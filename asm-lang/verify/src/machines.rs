//! Systems of several machines, with an environment and messages, as transition systems.
//!
//! A transition is a step of the machines that the schedule selects, and then one of the environment, if it is a specification: it
//! prepares the inputs of the next transition. A state is therefore observed between the environment's step and the system's: with the
//! inputs that the system reads next.

use crate::decisions::{DecidedChoices, Decisions, InputValue};
use crate::delivery::{Arrivals, MessageDelivery};
use crate::post::{ByteReader, Post, write_number};
use crate::system::MachineSchedule;
use crate::system_inputs::{OtherMachines, SystemInputs};
use crate::system_plan::SystemPlan;
use crate::transition::{ConditionTerm, FairLabels, MachineFault, TransitionSystem};
use asmotion_lang::hir::AddedTerm;
use asmotion_lang::ir::FunctionId;
use asmotion_lang::machine::pack_value;
use asmotion_lang::{Machine, Value};

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
    /// Events of messages in the last step.
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

    /// Moves machines at the same time: messages arrive, the machines make a step, and their messages leave. Returns `true` if
    /// something changed.
    fn advance(
        &mut self,
        movers: &[usize],
        decisions: &Decisions,
        known: &[InputValue],
    ) -> Result<bool, MachineFault> {
        let uses_messages = self.plan.messages.is_used();
        let mut has_changed = false;
        for &index in movers.iter().filter(|_| uses_messages) {
            let arrivals = self.delivery(decisions).arrive(index);
            has_changed |= arrivals.is_any;
            self.label |= self.label_of_arrivals(index, arrivals.label);
        }
        for &index in movers {
            has_changed |= self.execute(index, decisions, known)?;
        }
        for &index in movers.iter().filter(|_| uses_messages) {
            has_changed |= self.delivery(decisions).send(index)?;
        }
        Ok(has_changed)
    }

    /// Returns `true` if the schedule selects one of several machines.
    fn is_interleaved(&self) -> bool {
        self.plan.schedule == MachineSchedule::Interleaved && self.plan.scheduled().len() > 1
    }

    /// Returns the bits of a label for what is not made to wait at a machine. If one machine moves at a time, the label names it;
    /// otherwise the bits are those of this machine.
    fn label_of_arrivals(&self, receiver: usize, arrivals: u32) -> u32 {
        if self.is_interleaved() {
            let is_surrounding = Some(receiver) == self.plan.environment;
            return if is_surrounding { 0 } else { arrivals };
        }
        let machines = self.machines.len();
        let mut label = 0;
        for sender in 0..machines {
            let bit = if sender == receiver {
                Arrivals::CALLS
            } else {
                Arrivals::of_sender(sender)
            };
            if arrivals & bit != 0 {
                label |= Arrivals::between(sender, receiver, machines);
            }
        }
        label
    }

    /// Executes the step of one machine. Returns `true` if it updates a location.
    fn execute(
        &mut self,
        index: usize,
        decisions: &Decisions,
        known: &[InputValue],
    ) -> Result<bool, MachineFault> {
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
            others: OtherMachines {
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
            Ok(step) => Ok(!step.updates().is_empty()),
            Err(fault) => Err(MachineFault::of_step(index, fault)),
        }
    }

    fn delivery<'s>(&'s mut self, decisions: &'s Decisions) -> MessageDelivery<'s> {
        MessageDelivery {
            plan: &self.plan.messages,
            names: &self.plan.names,
            machines: &mut self.machines,
            post: &mut self.post,
            decisions,
            steps: self.scripted,
            events: &mut self.events,
        }
    }

    /// Keeps the inputs that the transition read, if inputs keep their values. Of those that properties mention, these are the ones
    /// that a step read as well: what properties mention must not restrict the states.
    fn hold(&mut self, decisions: &Decisions, known: &[InputValue]) {
        if self.plan.changes.is_none() {
            return;
        }
        let moved = &self.moved;
        self.held.retain(|input| !moved.contains(&input.machine));
        let is_read = |input: &&InputValue| {
            let machine = self.machines.get(input.machine);
            moved.contains(&input.machine) && machine.is_some_and(|it| has_read(it, input))
        };
        let known = known.iter().filter(is_read).cloned();
        let known: Vec<InputValue> = known.collect();
        for input in known.into_iter().chain(decisions.read()) {
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
            self.advance(&[environment], decisions, &[])?;
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

    fn has_surroundings(&self) -> bool {
        self.plan.environment.is_some() || self.plan.changes.is_some()
    }

    fn pack_own(&self, to: &mut Vec<u8>) {
        for index in self.plan.scheduled() {
            if let Some(machine) = self.machines.get(index) {
                machine.pack_state(to);
            }
        }
        self.post.pack(&self.machines, to);
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
        let mut has_changed = self.advance(&movers, decisions, known)?;
        self.hold(decisions, known);
        self.scripted += 1;
        if let Some(environment) = self.plan.environment {
            has_changed |= self.advance(&[environment], decisions, &[])?;
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
                others: OtherMachines {
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
        let is_interleaved = self.is_interleaved();
        let messages = &self.plan.messages;
        let senders = if messages.model.is_delayed {
            self.machines.len()
        } else {
            0
        };
        let mut fair = Vec::new();
        for index in self.plan.scheduled() {
            // the schedule selects each machine again and again
            let selected = FairLabels {
                mask: MACHINE,
                value: index as u32,
            };
            fair.extend(is_interleaved.then_some(selected));
            if !messages.is_used() {
                continue;
            }
            // calls end at their deadline, and messages arrive
            let others = (0..senders).filter(|sender| *sender != index);
            fair.extend([index].into_iter().chain(others).map(|sender| {
                if !is_interleaved {
                    let bit = Arrivals::between(sender, index, self.machines.len());
                    return FairLabels {
                        mask: bit,
                        value: bit,
                    };
                }
                let bit = if sender == index {
                    Arrivals::CALLS
                } else {
                    Arrivals::of_sender(sender)
                };
                FairLabels {
                    mask: MACHINE | bit,
                    value: index as u32 | bit,
                }
            }));
        }
        fair
    }
}

/// Returns `true` if the last step of a machine read an input.
fn has_read(machine: &Machine, input: &InputValue) -> bool {
    let slot = machine
        .state()
        .slot(machine.program(), input.function, &input.arguments);
    slot.is_some_and(|slot| {
        let mut inputs = machine.last_step().inputs().iter();
        inputs.any(|it| it.slot == slot)
    })
}

/// The bits of a label that name the machine that the schedule selected.
const MACHINE: u32 = 0xff;
