//! Machines: a compiled program with its state.

use crate::back_end::BackEnd;
use crate::choose::Chooser;
use crate::direct::DirectUse;
use crate::environment::Environment;
use crate::fault::StepFault;
use crate::messages::{MessagesInTransit, SentMessage};
use crate::naming::Naming;
use crate::record::{StepChoice, StepInput, TakenCandidate};
use crate::run::code::{CompiledProgram, NativeCompiler};
use crate::run::{RuleStopped, StepContext};
use crate::scalar_updates;
use crate::scratch::Scratch;
use crate::state::MachineState;
use crate::updates::Update;
use crate::witness_notes::WitnessNotes;
use asmotion_ir::{DomainId, Origin, Program};
use asmotion_value::{Atom, Value};
use std::fmt;
use std::sync::Arc;

/// The last step: its inputs, choices, updates and output.
#[derive(Clone, Copy)]
pub struct Step<'a> {
    machine: &'a Machine,
}

impl<'a> Step<'a> {
    /// Returns the number of the step, from 1.
    pub fn number(self) -> u64 {
        self.machine.steps
    }

    /// Returns the values read from the environment, in order.
    pub fn inputs(self) -> &'a [StepInput] {
        &self.machine.scratch.record.inputs
    }

    /// Returns the choices, in order.
    pub fn choices(self) -> &'a [StepChoice] {
        &self.machine.scratch.record.choices
    }

    /// Returns the candidates that `choose` rules took, in order, after [`Machine::keep_candidates`]; otherwise none.
    pub fn candidates(self) -> &'a [TakenCandidate] {
        &self.machine.scratch.record.candidates
    }

    /// Returns the update set, in the order in which the rules produced it.
    pub fn updates(self) -> &'a [Update] {
        &self.machine.scratch.updates.list
    }

    /// Returns the previous values of the updated locations, in the same order.
    pub fn before(self) -> &'a [Value] {
        &self.machine.scratch.before
    }

    /// Returns the elements added to domains by `extend`.
    pub fn extended(self) -> &'a [(DomainId, Atom)] {
        &self.machine.scratch.updates.extended
    }

    /// Returns the texts written by `print`.
    pub fn printed(self) -> &'a [String] {
        &self.machine.scratch.record.printed
    }

    /// Returns the messages sent, in order.
    pub fn sent(self) -> &'a [SentMessage] {
        &self.machine.scratch.record.sent
    }

    /// Returns the time of the step, in nanoseconds.
    pub fn now_ns(self) -> i64 {
        self.machine.scratch.record.now_ns
    }
}

impl fmt::Debug for Step<'_> {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.debug_struct("Step")
            .field("number", &self.number())
            .field("inputs", &self.inputs())
            .field("choices", &self.choices())
            .field("updates", &self.updates())
            .finish_non_exhaustive()
    }
}

/// Work of a step. Each variable bound in the step adds 1.
const STEP: u64 = 20;

/// A compiled program with its state. Cloning shares the code and copies the state.
#[derive(Clone)]
pub struct Machine {
    pub(crate) program: Arc<Program>,
    pub(crate) code: Arc<CompiledProgram>,
    pub(crate) state: MachineState,
    pub(crate) scratch: Scratch,
    /// Messages that were sent and not yet consumed.
    pub(crate) messages: MessagesInTransit,
    pub(crate) steps: u64,
    /// Number of steps and evaluations begun, failed ones included. Inputs are valid within one.
    pub(crate) rounds: u64,
    /// `true` once the initial state contains the values that depend on inputs.
    pub(crate) is_complete: bool,
    pub(crate) back_end: BackEnd,
    /// The compiler to native code; `None` in a build without one.
    pub(crate) native_compiler: Option<&'static dyn NativeCompiler>,
    /// Work done so far, in the unit of [`STEP`].
    pub(crate) work: u64,
    pub(crate) direct: DirectUse,
}

impl Machine {
    /// Compiles a program and builds its initial state.
    ///
    /// # Errors
    /// An initial value cannot be computed, or the initial state violates an invariant.
    pub fn new(program: Arc<Program>) -> Result<Self, Box<StepFault>> {
        let code = CompiledProgram::of(&program);
        let mut machine = Self::uninitialised(program, code);
        machine.initialise()?;
        Ok(machine)
    }

    /// Creates a machine without an initial state.
    pub(crate) fn uninitialised(program: Arc<Program>, code: CompiledProgram) -> Self {
        let state = MachineState::new(&program);
        Self {
            program,
            code: Arc::new(code),
            state,
            scratch: Scratch::default(),
            messages: MessagesInTransit::default(),
            steps: 0,
            rounds: 0,
            is_complete: false,
            back_end: BackEnd::default(),
            native_compiler: None,
            work: 0,
            direct: DirectUse::default(),
        }
    }

    /// Creates a machine in the same state with other closures.
    pub(crate) fn recompiled(&self, code: CompiledProgram) -> Self {
        Self {
            code: Arc::new(code),
            back_end: BackEnd::Closures,
            direct: DirectUse::default(),
            ..self.clone()
        }
    }

    /// Keeps the candidates that `choose` rules take: see [`Step::candidates`]. Closures execute all steps from now on.
    pub fn keep_candidates(&mut self) {
        self.scratch.record.keeps_candidates = true;
        self.back_end = BackEnd::Closures;
    }

    /// Starts recording; requires recording code.
    pub(crate) fn watch(&mut self, notes: WitnessNotes) {
        self.scratch.notes = Some(notes);
    }

    /// Returns the records and ends recording.
    pub(crate) fn notes(&mut self) -> Option<WitnessNotes> {
        self.scratch.notes.take()
    }

    /// Replaces the code.
    pub(crate) fn set_code(&mut self, code: CompiledProgram) {
        self.code = Arc::new(code);
        self.direct = DirectUse::default();
    }

    /// Returns the program that the machine executes.
    pub fn program(&self) -> &Arc<Program> {
        &self.program
    }

    /// Returns the current state.
    pub fn state(&self) -> &MachineState {
        &self.state
    }

    /// Returns the values of all slots, indexed by slot.
    pub fn slots(&self) -> &[Value] {
        &self.state.store.slots
    }

    /// Returns the values of all slots, for callers that store states themselves. Requires [`Machine::can_revert`]. The
    /// values are not checked: each must be one that this machine had in that slot.
    pub fn slots_mut(&mut self) -> &mut [Value] {
        &mut self.state.store.slots
    }

    /// Returns the number of completed steps.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Returns the names of the machine's atoms and rules.
    pub fn naming(&self) -> Naming<'_> {
        Naming {
            program: &self.program,
            reserve: &self.state.store.reserve,
        }
    }

    /// Executes one step. `now_ns`, in nanoseconds, is the time that clock functions return.
    ///
    /// # Errors
    /// The step has no next state, and the state is unchanged. The exception is a violated
    /// invariant of the new state, which is reported after the step was completed.
    pub fn step(
        &mut self,
        environment: &mut dyn Environment,
        chooser: &mut dyn Chooser,
        now_ns: i64,
    ) -> Result<Step<'_>, Box<StepFault>> {
        if self.direct.is_ready && self.collects_directly(true, chooser, now_ns) {
            self.steps += 1;
            self.recheck(environment, chooser, now_ns)?;
            return Ok(self.last_step());
        }
        self.step_otherwise(environment, chooser, now_ns)
    }

    /// Executes a step for which the direct rule is not ready, or gave up.
    #[inline(never)]
    fn step_otherwise(
        &mut self,
        environment: &mut dyn Environment,
        chooser: &mut dyn Chooser,
        now_ns: i64,
    ) -> Result<Step<'_>, Box<StepFault>> {
        let number = self.steps + 1;
        let is_tried = self.direct.is_ready;
        if is_tried || !self.is_direct() || !self.collects_directly(true, chooser, now_ns) {
            let is_native = self.is_native();
            let choices = &mut self.repeating(chooser);
            self.attempt(true, environment, choices, now_ns, |run| {
                run.main_rule(is_native)
            })?;
        }
        self.steps = number;
        self.recheck(environment, chooser, now_ns)?;
        Ok(self.last_step())
    }

    /// Evaluates rules in the current state and applies their updates. The first step also
    /// completes the initial state with its inputs and checks it.
    #[inline]
    pub(crate) fn attempt(
        &mut self,
        is_step: bool,
        environment: &mut dyn Environment,
        chooser: &mut dyn Chooser,
        now_ns: i64,
        rules: impl FnOnce(&mut StepContext<'_>) -> Result<(), RuleStopped>,
    ) -> Result<(), Box<StepFault>> {
        self.collect(is_step, environment, chooser, now_ns, rules)?;
        self.fire_updates();
        self.state.commit();
        if self.program.messages.is_some() {
            let record = &mut self.scratch.record;
            self.messages
                .finish_step(&record.performed, now_ns, &mut record.sent);
        }
        Ok(())
    }

    /// Evaluates rules in the current state and collects their updates.
    #[inline(always)]
    pub(crate) fn collect(
        &mut self,
        is_step: bool,
        environment: &mut dyn Environment,
        chooser: &mut dyn Chooser,
        now_ns: i64,
        rules: impl FnOnce(&mut StepContext<'_>) -> Result<(), RuleStopped>,
    ) -> Result<(), Box<StepFault>> {
        self.rounds += 1;
        self.scratch.begin(now_ns);
        self.scratch.updates.begin(self.state.slot_count());
        self.state.forget_uncommitted();
        let reserve = self.state.store.reserve.len();
        self.scratch.begun_at = (self.steps, reserve);
        if !self.is_complete {
            self.initialise_with_inputs(environment, now_ns)?;
        }
        if is_step && self.steps == 0 && self.program.needs_inputs() {
            self.check_initial(environment, now_ns)?;
        }
        if self.program.messages.is_some() {
            self.messages.begin_step(now_ns);
        }
        let number = self.steps + 1;
        let evaluated = self.run(environment, chooser, number, now_ns, |run| {
            // a fault was recorded where it occurred
            if rules(run).is_ok() && !run.record.performed.is_empty() {
                let _ = run.finish_messages();
            }
            u64::from(run.bindings)
        });
        match evaluated {
            Ok(bindings) => {
                self.work += STEP + bindings;
                Ok(())
            }
            Err(fault) => {
                self.state.store.reserve.truncate(reserve);
                Err(fault)
            }
        }
    }

    /// Checks the invariants of the state after the last step once more.
    #[inline(always)]
    pub(crate) fn recheck(
        &mut self,
        environment: &mut dyn Environment,
        chooser: &mut dyn Chooser,
        now_ns: i64,
    ) -> Result<(), Box<StepFault>> {
        if self.program.invariants.is_empty() {
            Ok(())
        } else {
            self.check_new_state(environment, chooser, now_ns)
        }
    }

    #[inline(never)]
    fn check_new_state(
        &mut self,
        environment: &mut dyn Environment,
        chooser: &mut dyn Chooser,
        now_ns: i64,
    ) -> Result<(), Box<StepFault>> {
        let checked = self.run(environment, chooser, self.steps, now_ns, |run| {
            // the context records a violation as a fault
            let _ = run.check_invariants(false);
        });
        if self.program.compatible {
            // in the reference, reading a location makes it part of the state
            self.state.commit();
        }
        checked
    }

    /// Discards the last step, but keeps the coverage counters.
    pub(crate) fn forget_last_step(&mut self) {
        self.scratch.begin(0);
        self.scratch.updates.begin(self.state.slot_count());
    }

    /// Returns the last step, successful or failed; before the first step, its update set is empty.
    pub fn last_step(&self) -> Step<'_> {
        Step { machine: self }
    }

    /// Returns the values that the chooser picked in the last step, with the places of the
    /// variables' ranges.
    pub(crate) fn picked(&self) -> &[(Origin, Value)] {
        &self.scratch.record.picked
    }

    /// Returns the coverage counts for [`asmotion_ir::Program::counted`], including those of failed
    /// steps.
    pub fn counts(&self) -> Vec<u64> {
        let record = &self.scratch.record;
        let counters = 0..self.program.counted.len() as u32;
        counters.map(|counter| record.counted(counter)).collect()
    }

    /// Returns one of the coverage counts.
    #[inline]
    pub fn count(&self, counter: u32) -> u64 {
        self.scratch.record.counted(counter)
    }

    /// Applies the update set to the state.
    #[inline]
    fn fire_updates(&mut self) {
        let Scratch {
            updates,
            before,
            is_plain,
            ..
        } = &mut self.scratch;
        let slots = &mut self.state.store.slots;
        *is_plain = scalar_updates::fire(&updates.list, slots, before);
        for &(domain, atom) in &updates.extended {
            for &domain in &self.code.supers[domain.0 as usize] {
                Arc::make_mut(&mut self.state.store.extents[domain.0 as usize])
                    .push(Value::Atom(atom));
            }
        }
    }

    /// Returns `true` if [`Machine::revert`] can reverse the next step: it changes nothing but locations and extents.
    pub fn can_revert(&self) -> bool {
        self.is_complete
            && self.program.messages.is_none()
            && !self.program.compatible
            && !self.code.layout.keeps_inputs
            && (self.steps > 0 || !self.code.layout.first_differs)
    }

    /// Reverses the last step, which [`Machine::can_revert`] permitted before it. After a failed step this has no effect,
    /// except for a violated invariant, before which the step was completed.
    ///
    /// Accessed locations remain: they have no influence on later steps. The record of the step remains as well.
    pub fn revert(&mut self) {
        let Scratch {
            updates,
            before,
            begun_at: (steps, reserve),
            is_plain,
            ..
        } = &mut self.scratch;
        let slots = &mut self.state.store.slots;
        for (update, before) in updates.list.iter().zip(before.iter_mut()) {
            slots[update.slot as usize] = std::mem::take(before);
        }
        if self.steps > *steps {
            for &(domain, _) in updates.extended.iter().rev() {
                for &domain in &self.code.supers[domain.0 as usize] {
                    Arc::make_mut(&mut self.state.store.extents[domain.0 as usize]).pop();
                }
            }
            self.state.store.reserve.truncate(*reserve);
        }
        before.clear();
        *is_plain = false;
        self.scratch.is_direct = false;
        self.steps = self.scratch.begun_at.0;
    }

    /// Runs `work` in the context of a step.
    #[inline]
    pub(crate) fn run<T>(
        &mut self,
        environment: &mut dyn Environment,
        chooser: &mut dyn Chooser,
        step: u64,
        now_ns: i64,
        work: impl FnOnce(&mut StepContext<'_>) -> T,
    ) -> Result<T, Box<StepFault>> {
        self.scratch.is_direct = false;
        let Scratch {
            updates,
            record,
            locals,
            stack,
            notes,
            ..
        } = &mut self.scratch;
        locals.clear();
        stack.clear();
        let mut run = StepContext {
            program: &self.program,
            code: &self.code,
            state: &mut self.state,
            messages: &self.messages,
            updates,
            environment,
            chooser,
            record,
            locals,
            stack,
            base: 0,
            agent: Value::Undef,
            depth: 0,
            runs: 0,
            iterations: 0,
            bindings: 0,
            calls: 0,
            step,
            round: self.rounds,
            now_ns,
            building: false,
            is_before: false,
            fault: None,
            is_fault_final: false,
            notes,
        };
        let grown = run.updates.grown();
        let result = work(&mut run);
        if let Some(fault) = run.fault.take() {
            run.abandon(grown);
            return Err(fault);
        }
        let StepContext { agent, .. } = run;
        agent.discard();
        Ok(result)
    }
}
