//! Operations on a machine between its steps: evaluating terms, firing rules, setting locations.

use crate::choose::{Chooser, FirstChoice};
use crate::environment::{Environment, NoInputs};
use crate::fault::{FaultKind, StepFault};
use crate::machine::{Machine, Step};
use crate::messages::{CallFault, MessageId};
use crate::run::CodomainCheck;
use crate::run::code::CompiledProgram;
use asmotion_ir::{
    AddedRule, AddedTerm, Assignment, FunctionId, FunctionKind, Origin, Program, Slot,
};
use asmotion_value::Value;
use std::sync::Arc;

/// The program's locations differ from those of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ForeignProgram;

impl Machine {
    /// Fires a rule that was added to the program. This is not a step: the step counter does not
    /// change, and no invariant is checked.
    ///
    /// # Errors
    /// The rule fails or its updates are inconsistent; the state is unchanged.
    pub fn fire(
        &mut self,
        rule: AddedRule,
        environment: &mut dyn Environment,
        chooser: &mut dyn Chooser,
        now_ns: i64,
    ) -> Result<Step<'_>, Box<StepFault>> {
        self.changed_outside();
        self.attempt(false, environment, chooser, now_ns, |run| {
            match run.program.added_rules.get(rule.0 as usize) {
                Some(&routine) => run.call_routine(routine, 0),
                None => Ok(()),
            }
        })?;
        Ok(self.last_step())
    }

    /// Executes a step with a rule that was added to the program in place of the main rule. Assumptions about inputs are not
    /// checked: the rule can react to inputs that violate them.
    ///
    /// # Errors
    /// As [`Machine::step`].
    pub fn step_with(
        &mut self,
        rule: AddedRule,
        environment: &mut dyn Environment,
        chooser: &mut dyn Chooser,
        now_ns: i64,
    ) -> Result<Step<'_>, Box<StepFault>> {
        self.changed_outside();
        let number = self.steps + 1;
        self.attempt(true, environment, chooser, now_ns, |run| {
            match run.program.added_rules.get(rule.0 as usize) {
                Some(&routine) => run.call_routine(routine, 0),
                None => Ok(()),
            }
        })?;
        self.steps = number;
        self.recheck(environment, chooser, now_ns)?;
        Ok(self.last_step())
    }

    /// Evaluates a term that was added to the program in the current state. The environment is
    /// asked again for the inputs that the term needs; the state is otherwise unchanged.
    ///
    /// # Errors
    /// The evaluation fails.
    pub fn evaluate(
        &mut self,
        term: AddedTerm,
        environment: &mut dyn Environment,
        now_ns: i64,
    ) -> Result<Value, Box<StepFault>> {
        if !self.is_complete {
            let mut complete = self.clone();
            complete.rounds += 1;
            complete.initialise_with_inputs(environment, now_ns)?;
            return complete.evaluate(term, environment, now_ns);
        }
        self.rounds += 1;
        let step = self.steps + 1;
        self.outside_step(|machine| {
            machine.run(environment, &mut FirstChoice, step, now_ns, |run| match run
                .program
                .added_terms
                .get(term.0 as usize)
            {
                Some(&body) => run.call_body(body, 0),
                None => Value::Undef,
            })
        })
    }

    /// Evaluates several terms like [`Machine::evaluate`], at less cost for each. The environment is asked at most once for an
    /// input that several of them need.
    ///
    /// # Errors
    /// The evaluation of a term fails: its index in `terms`, and the fault.
    pub fn evaluate_each(
        &mut self,
        terms: &[AddedTerm],
        environment: &mut dyn Environment,
        now_ns: i64,
        values: &mut Vec<Value>,
    ) -> Result<(), (usize, Box<StepFault>)> {
        if !self.is_complete {
            let mut complete = self.clone();
            complete.rounds += 1;
            let completed = complete.initialise_with_inputs(environment, now_ns);
            completed.map_err(|fault| (0, fault))?;
            return complete.evaluate_each(terms, environment, now_ns, values);
        }
        self.rounds += 1;
        let step = self.steps + 1;
        let mut failed = 0;
        let evaluated = self.outside_step(|machine| {
            machine.run(environment, &mut FirstChoice, step, now_ns, |run| {
                for (index, term) in terms.iter().enumerate() {
                    let body = run.program.added_terms.get(term.0 as usize);
                    let value = body.map_or(Value::Undef, |&body| run.call_body(body, 0));
                    if run.fault.is_some() {
                        failed = index;
                        return;
                    }
                    values.push(value);
                }
            })
        });
        evaluated.map_err(|fault| (failed, fault))
    }

    /// Checks the invariants in the current state, except assumptions about the environment.
    ///
    /// # Errors
    /// An invariant is violated.
    pub fn check_invariants(
        &mut self,
        environment: &mut dyn Environment,
        now_ns: i64,
    ) -> Result<(), Box<StepFault>> {
        self.rounds += 1;
        let step = self.steps;
        self.outside_step(|machine| {
            machine.run(environment, &mut FirstChoice, step, now_ns, |run| {
                // a violation is the fault of the run
                let _ = run.check_invariants(false);
            })
        })
    }

    /// Sets the value of a location from outside. For a monitored location, the environment still
    /// takes precedence the next time it is read.
    ///
    /// # Errors
    /// The value is outside the codomain.
    pub fn set(
        &mut self,
        function: FunctionId,
        arguments: &[Value],
        value: Value,
    ) -> Result<Slot, Box<StepFault>> {
        self.changed_outside();
        let step = self.steps;
        let is_input = matches!(
            self.program.functions[function.0 as usize].kind,
            FunctionKind::Monitored | FunctionKind::Shared
        );
        self.outside_step(|machine| {
            machine.run(&mut NoInputs, &mut FirstChoice, step, 0, |run| {
                run.stack.extend_from_slice(arguments);
                let slot = run.slot(function, 0);
                let codomain = CodomainCheck::of(run.program, function);
                let nowhere = Origin::default();
                // the context records a misfit as a fault
                if let Some(misfit) = run.misfit(function, &value).filter(|_| is_input) {
                    let source = "a `set`".to_owned();
                    let kind = FaultKind::OutsideInput {
                        slot,
                        misfit,
                        source,
                    };
                    run.fail(kind, nowhere);
                } else if run.accepts(slot, &value, codomain, nowhere).is_ok() {
                    run.state.store.slots[slot as usize] = value;
                }
                slot
            })
        })
    }

    /// Returns the value of a location, which is accessed if it was not yet.
    pub(crate) fn interned_value(&mut self, function: FunctionId, arguments: &[Value]) -> Value {
        let step = self.steps;
        let slot = self.outside_step(|machine| {
            machine.run(&mut NoInputs, &mut FirstChoice, step, 0, |run| {
                run.stack.extend_from_slice(arguments);
                run.slot(function, 0)
            })
        });
        let slot = slot
            .ok()
            .and_then(|slot| self.state.store.slots.get(slot as usize));
        slot.cloned().unwrap_or_default()
    }

    /// Evaluates an assignment from outside in the current state; returns the function, the
    /// arguments and the value.
    ///
    /// # Errors
    /// The evaluation of an argument or of the value fails.
    pub fn assigned(
        &mut self,
        assignment: &Assignment,
        environment: &mut dyn Environment,
        now_ns: i64,
    ) -> Result<(FunctionId, Vec<Value>, Value), Box<StepFault>> {
        let function = FunctionId(assignment.function.0);
        let value = self.evaluate(assignment.value, environment, now_ns)?;
        let mut arguments = Vec::new();
        for &argument in &assignment.arguments {
            arguments.push(self.evaluate(argument, environment, now_ns)?);
        }
        let expected = self.program.functions[function.0 as usize].parameters.len();
        if let ([Value::Tuple(items)], true) = (arguments.as_slice(), expected > 1) {
            arguments = items.to_vec();
        }
        Ok((function, arguments, value))
    }

    /// Sets the agents that are outside. Messages to them are marked
    /// [`SentMessage::leaves`](crate::SentMessage::leaves) and not delivered by the machine.
    pub fn set_partners(&mut self, partners: Vec<Value>) {
        self.messages.set_partners(partners);
    }

    /// Queues a message of a partner for an agent. The returned id is the one that a reply refers
    /// to.
    pub fn deliver(&mut self, from: Value, to: Value, operation: &str, data: Value) -> MessageId {
        self.messages
            .deliver(from, to, Value::text(operation), data)
    }

    /// Ends a call with a reply or a fault. Does nothing if the call has already ended.
    pub fn end_call(&mut self, call: MessageId, outcome: Result<Value, CallFault>) {
        self.messages.end_call(call, outcome);
    }

    /// Reports that the last message of an agent could not be sent.
    pub fn set_unsent(&mut self, from: Value, operation: &str) {
        self.messages.set_unsent(from, operation);
    }

    /// Sets the state of the channel: `true` if it delivers no messages at present.
    pub fn set_channel_down(&mut self, is_down: bool) {
        self.messages.set_down(is_down);
    }

    /// Returns the number of messages dropped from full queues.
    pub fn dropped_messages(&self) -> u64 {
        self.messages.dropped()
    }

    /// Replaces the program by one that differs only in its added terms and rules.
    ///
    /// # Errors
    /// The program has other locations; the machine is unchanged.
    pub fn replace_program(&mut self, program: Arc<Program>) -> Result<(), ForeignProgram> {
        let is_own = self.program.slots == program.slots
            && self.program.functions.len() <= program.functions.len()
            && self.program.domains.len() == program.domains.len()
            && self.program.caches == program.caches
            && self.program.atom_domains == program.atom_domains;
        if !is_own {
            return Err(ForeignProgram);
        }
        self.set_code(CompiledProgram::of(&program));
        self.program = program;
        Ok(())
    }

    /// Runs `work` outside a step, preserving the record of the last step. `work` evaluates terms, which add no updates.
    fn outside_step<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T {
        let sizes = self.scratch.record.sizes();
        let result = work(self);
        self.scratch.record.shrink(&sizes);
        result
    }
}
