//! What is done to a machine between its steps: terms evaluated, rules fired, locations set.

use crate::choose::{Chooser, FirstChoice};
use crate::code::CompiledProgram;
use crate::environment::{Environment, NoInputs};
use crate::fault::{FaultKind, StepFault};
use crate::machine::{Machine, Step};
use crate::messages::{CallFault, MessageId};
use crate::run::CodomainCheck;
use asmotion_ir::{
    AddedRule, AddedTerm, Assignment, FunctionId, FunctionKind, Origin, Program, Slot,
};
use asmotion_value::Value;
use std::sync::Arc;

/// A program has other locations than the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ForeignProgram;

impl Machine {
    /// Fires a rule that was added to the program. This is no step: none is counted, and no
    /// invariant is checked.
    ///
    /// # Errors
    /// The rule fails, or its updates are inconsistent; the state is as before.
    pub fn fire(
        &mut self,
        rule: AddedRule,
        environment: &mut dyn Environment,
        chooser: &mut dyn Chooser,
        now_ns: i64,
    ) -> Result<Step<'_>, Box<StepFault>> {
        self.attempt(false, environment, chooser, now_ns, |run| {
            match run.program.added_rules.get(rule.0 as usize) {
                Some(&routine) => run.call_routine(routine, 0),
                None => Ok(()),
            }
        })?;
        Ok(self.last_step())
    }

    /// The value of a term that was added to the program, in the current state. Nothing changes but
    /// what was heard of the environment, which is asked anew.
    ///
    /// # Errors
    /// The term has no value.
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
        self.aside(|machine| {
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

    /// Checks the invariants that rules must keep, in the current state.
    ///
    /// # Errors
    /// One is violated.
    pub fn check_invariants(
        &mut self,
        environment: &mut dyn Environment,
        now_ns: i64,
    ) -> Result<(), Box<StepFault>> {
        self.rounds += 1;
        let step = self.steps;
        self.aside(|machine| {
            machine.run(environment, &mut FirstChoice, step, now_ns, |run| {
                // a violation is the fault of the run
                let _ = run.check_invariants(false);
            })
        })
    }

    /// Gives a location a value from outside. A monitored location is asked of the environment all
    /// the same when it is read next.
    ///
    /// # Errors
    /// The value is no element of the codomain.
    pub fn set(
        &mut self,
        function: FunctionId,
        arguments: &[Value],
        value: Value,
    ) -> Result<Slot, Box<StepFault>> {
        let step = self.steps;
        let is_input = matches!(
            self.program.functions[function.0 as usize].kind,
            FunctionKind::Monitored | FunctionKind::Shared
        );
        self.aside(|machine| {
            machine.run(&mut NoInputs, &mut FirstChoice, step, 0, |run| {
                run.stack.extend_from_slice(arguments);
                let slot = run.slot(function, 0);
                let codomain = CodomainCheck::of(run.program, function);
                let nowhere = Origin::default();
                // what is wrong with the value is the fault of the run
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

    /// The location and the value an assignment from outside speaks of, in the current state.
    ///
    /// # Errors
    /// An argument or the value has no value.
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
        let wanted = self.program.functions[function.0 as usize].parameters.len();
        if let ([Value::Tuple(items)], true) = (arguments.as_slice(), wanted > 1) {
            arguments = items.to_vec();
        }
        Ok((function, arguments, value))
    }

    /// Says which agents are outside: messages to them are given out, see [`Sent::leaves`](crate::SentMessage::leaves), and not
    /// delivered.
    pub fn set_partners(&mut self, partners: Vec<Value>) {
        self.post.set_partners(partners);
    }

    /// Brings a message of a partner to an agent. A reply to it is one to this number.
    pub fn deliver(&mut self, from: Value, to: Value, operation: &str, data: Value) -> MessageId {
        self.post.deliver(from, to, Value::text(operation), data)
    }

    /// Brings the end of a call to the agent that waits for it; nothing if none does any longer.
    pub fn end_call(&mut self, call: MessageId, outcome: Result<Value, CallFault>) {
        self.post.end_call(call, outcome);
    }

    /// Says that the last message of an agent could not be sent.
    pub fn set_unsent(&mut self, from: Value, operation: &str) {
        self.post.set_unsent(from, operation);
    }

    /// Says whether messages do not go out at present.
    pub fn set_channel_down(&mut self, is_down: bool) {
        self.post.set_down(is_down);
    }

    /// How many messages were dropped because too many waited.
    pub fn dropped_messages(&self) -> u64 {
        self.post.dropped()
    }

    /// Goes on with a program that differs in what was added to it.
    ///
    /// # Errors
    /// The program has other locations; the machine is as before.
    pub fn adopt(&mut self, program: Arc<Program>) -> Result<(), ForeignProgram> {
        let is_own = self.program.slots == program.slots
            && self.program.functions.len() <= program.functions.len()
            && self.program.domains.len() == program.domains.len()
            && self.program.caches == program.caches
            && self.program.atom_domains == program.atom_domains;
        if !is_own {
            return Err(ForeignProgram);
        }
        self.code = Arc::new(CompiledProgram::of(&program));
        self.program = program;
        Ok(())
    }

    /// Does something that is no part of a step: what the last one read and wrote is kept.
    fn aside<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T {
        let kept = std::mem::take(&mut self.scratch);
        self.scratch.updates.begin(self.state.len());
        let result = work(self);
        self.scratch = kept;
        result
    }
}
