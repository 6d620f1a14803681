//! A machine: a compiled program and its state.

use crate::back_end::BackEnd;
use crate::choose::Chooser;
use crate::code::{CompiledProgram, NativeCompiler, NoNativeCode};
use crate::environment::Environment;
use crate::fault::{FaultKind, StepFault};
use crate::messages::{MessagesInTransit, SentMessage};
use crate::naming::Naming;
use crate::notes::WitnessNotes;
use crate::plain;
use crate::record::{StepChoice, StepInput, StepLog};
use crate::run::{RuleStopped, StepContext};
use crate::state::MachineState;
use crate::updates::{Update, Updates};
use asmotion_ir::{DomainId, Origin, Program};
use asmotion_value::{Atom, Value};
use std::fmt;
use std::sync::Arc;

/// A step that was done: what it read, chose and wrote.
#[derive(Clone, Copy)]
pub struct Step<'a> {
    machine: &'a Machine,
}

impl<'a> Step<'a> {
    /// Its number, from 1.
    pub fn number(self) -> u64 {
        self.machine.steps
    }

    /// What was read of the environment, in order.
    pub fn inputs(self) -> &'a [StepInput] {
        &self.machine.scratch.record.inputs
    }

    /// What was chosen, in order.
    pub fn choices(self) -> &'a [StepChoice] {
        &self.machine.scratch.record.choices
    }

    /// The update set, in the order the rules wrote it.
    pub fn updates(self) -> &'a [Update] {
        &self.machine.scratch.updates.list
    }

    /// What each updated location held before, in the same order.
    pub fn before(self) -> &'a [Value] {
        &self.machine.scratch.before
    }

    /// The elements that joined a domain.
    pub fn extended(self) -> &'a [(DomainId, Atom)] {
        &self.machine.scratch.updates.extended
    }

    /// What `print` wrote.
    pub fn printed(self) -> &'a [String] {
        &self.machine.scratch.record.printed
    }

    /// The messages it sent, in order.
    pub fn sent(self) -> &'a [SentMessage] {
        &self.machine.scratch.record.sent
    }

    /// The time it was done at.
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

/// When a machine has done so much, compiling its main rule to native code is worth while.
const WARM: u64 = 10_000;

/// What a step counts; a variable bound within counts one.
const STEP: u64 = 20;

/// A program, compiled, and its state. Cloning shares the code and copies the state.
#[derive(Clone)]
pub struct Machine {
    pub(crate) program: Arc<Program>,
    pub(crate) code: Arc<CompiledProgram>,
    pub(crate) state: MachineState,
    pub(crate) scratch: Scratch,
    /// Messages on their way.
    pub(crate) post: MessagesInTransit,
    pub(crate) steps: u64,
    /// How often a step was begun: what was asked of the environment counts for one of them.
    pub(crate) rounds: u64,
    /// Whether the initial state holds the values that depend on inputs.
    pub(crate) is_complete: bool,
    back_end: BackEnd,
    /// What compiles its main rule to native code, if the build has such a thing.
    native_compiler: Option<&'static dyn NativeCompiler>,
    /// How much its steps had to do.
    work: u64,
}

/// What a step needs and the next one can use again.
#[derive(Default)]
pub(crate) struct Scratch {
    pub updates: Updates,
    record: StepLog,
    locals: Vec<Value>,
    stack: Vec<Value>,
    before: Vec<Value>,
    /// Whether nothing that the last step wrote, or found there, must be dropped.
    is_plain: bool,
    /// Only where a failed step is done once more.
    notes: Option<WitnessNotes>,
}

impl Scratch {
    /// Forgets the last step.
    #[inline]
    fn begin(&mut self, now_ns: i64) {
        self.record.begin(now_ns);
        if self.is_plain {
            plain::forget(&mut self.before);
            plain::forget(&mut self.updates.list);
        } else {
            self.before.clear();
            self.updates.list.clear();
        }
        // whatever becomes of this step
        self.is_plain = false;
    }
}

impl Clone for Scratch {
    /// Scratch holds nothing that outlives a step.
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl Machine {
    /// Compiles a program and builds its initial state.
    ///
    /// # Errors
    /// An initial value cannot be computed, or an invariant does not hold initially.
    pub fn new(program: Arc<Program>) -> Result<Self, Box<StepFault>> {
        let code = CompiledProgram::of(&program);
        let mut machine = Self::blank(program, code);
        machine.initialise()?;
        Ok(machine)
    }

    /// A machine whose initial state is still to be built.
    pub(crate) fn blank(program: Arc<Program>, code: CompiledProgram) -> Self {
        let state = MachineState::new(&program);
        Self {
            program,
            code: Arc::new(code),
            state,
            scratch: Scratch::default(),
            post: MessagesInTransit::default(),
            steps: 0,
            rounds: 0,
            is_complete: false,
            back_end: BackEnd::default(),
            native_compiler: None,
            work: 0,
        }
    }

    /// A machine in the same state with other closures.
    pub(crate) fn recompiled(&self, code: CompiledProgram) -> Self {
        Self {
            code: Arc::new(code),
            back_end: BackEnd::Closures,
            ..self.clone()
        }
    }

    /// From now on, watched code notes what it sees on the way to this fault.
    pub(crate) fn watch(&mut self, fault: &StepFault) {
        self.scratch.notes = Some(WitnessNotes::about(fault));
    }

    /// What was noted.
    pub(crate) fn notes(&mut self) -> Option<WitnessNotes> {
        self.scratch.notes.take()
    }

    /// Gives the machine a compiler to native code. Until it has one, closures do all its steps.
    pub fn set_native_compiler(&mut self, compiler: &'static dyn NativeCompiler) {
        self.native_compiler = Some(compiler);
    }

    /// Says what does the steps from now on. Native code that is asked for is compiled at once.
    ///
    /// # Errors
    /// There is no native code for this machine: closures do its steps, which are the same.
    pub fn set_back_end(&mut self, back_end: BackEnd) -> Result<(), NoNativeCode> {
        self.back_end = back_end;
        match back_end {
            BackEnd::Auto | BackEnd::Closures => Ok(()),
            BackEnd::Native => self.compile_native(),
        }
    }

    /// What does the next step: closures, or native code.
    pub fn back_end(&self) -> BackEnd {
        match self.is_native() {
            true => BackEnd::Native,
            false => BackEnd::Closures,
        }
    }

    /// Whether native code does the next step; it is compiled now if the machine has become warm.
    #[inline]
    fn is_native(&self) -> bool {
        let is_wanted = match self.back_end {
            BackEnd::Auto => self.work >= WARM,
            BackEnd::Closures => false,
            BackEnd::Native => true,
        };
        is_wanted && self.compile_native().is_ok()
    }

    /// Compiles the main rule to native code, unless that was done before.
    #[inline]
    fn compile_native(&self) -> Result<(), NoNativeCode> {
        let compile = || match self.native_compiler {
            Some(compiler) => compiler.compile(&self.program),
            None => Err(NoNativeCode::NotBuilt),
        };
        match self.code.native.get_or_init(compile) {
            Ok(_) => Ok(()),
            Err(why) => Err(*why),
        }
    }

    /// The program.
    pub fn program(&self) -> &Arc<Program> {
        &self.program
    }

    /// The current state.
    pub fn state(&self) -> &MachineState {
        &self.state
    }

    /// How many steps were done.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// What the machine's atoms and rules are called.
    pub fn naming(&self) -> Naming<'_> {
        Naming {
            program: &self.program,
            reserve: &self.state.store.reserve,
        }
    }

    /// Does one step. `now_ns` is what the time functions of the library answer.
    ///
    /// # Errors
    /// The step has no next state; the state is as before. Only where an invariant of the new state
    /// is violated, the step was done.
    pub fn step(
        &mut self,
        environment: &mut dyn Environment,
        chooser: &mut dyn Chooser,
        now_ns: i64,
    ) -> Result<Step<'_>, Box<StepFault>> {
        let number = self.steps + 1;
        let is_native = self.is_native();
        self.attempt(true, environment, chooser, now_ns, |run| {
            match run.program.main {
                Some(main) => run.call_main(main, is_native)?,
                None => return Err(run.stop(FaultKind::NoMain, Origin::default())),
            }
            run.check_invariants(true)
        })?;
        self.steps = number;
        self.check_again(environment, chooser, now_ns)?;
        Ok(self.last_step())
    }

    /// Evaluates rules in the current state, and applies their updates. The first step checks the
    /// initial state, which its inputs complete.
    #[inline]
    pub(crate) fn attempt(
        &mut self,
        is_step: bool,
        environment: &mut dyn Environment,
        chooser: &mut dyn Chooser,
        now_ns: i64,
        rules: impl FnOnce(&mut StepContext<'_>) -> Result<(), RuleStopped>,
    ) -> Result<(), Box<StepFault>> {
        self.rounds += 1;
        self.scratch.begin(now_ns);
        self.scratch.updates.begin(self.state.len());
        self.state.forget_uncommitted();
        let reserve = self.state.store.reserve.len();
        if !self.is_complete {
            self.initialise_with_inputs(environment, now_ns)?;
        }
        if is_step && self.steps == 0 && self.program.needs_inputs() {
            self.check_initial(environment, now_ns)?;
        }
        if self.program.messages.is_some() {
            self.post.begin(now_ns);
        }
        let number = self.steps + 1;
        let evaluated = self.run(environment, chooser, number, now_ns, |run| {
            // whoever stopped has noted the fault
            if rules(run).is_ok() && !run.record.done.is_empty() {
                let _ = run.settle_status();
            }
            u64::from(run.bindings)
        });
        match evaluated {
            Ok(bindings) => self.work += STEP + bindings,
            Err(fault) => {
                self.state.store.reserve.truncate(reserve);
                return Err(fault);
            }
        }
        self.fire_updates();
        self.state.commit();
        if self.program.messages.is_some() {
            let record = &mut self.scratch.record;
            self.post.settle(&record.done, now_ns, &mut record.sent);
        }
        Ok(())
    }

    /// Checks the invariants of the state that the last step led to.
    #[inline(always)]
    pub(crate) fn check_again(
        &mut self,
        environment: &mut dyn Environment,
        chooser: &mut dyn Chooser,
        now_ns: i64,
    ) -> Result<(), Box<StepFault>> {
        match self.program.invariants.is_empty() {
            true => Ok(()),
            false => self.check_new_state(environment, chooser, now_ns),
        }
    }

    fn check_new_state(
        &mut self,
        environment: &mut dyn Environment,
        chooser: &mut dyn Chooser,
        now_ns: i64,
    ) -> Result<(), Box<StepFault>> {
        self.run(environment, chooser, self.steps, now_ns, |run| {
            // a violation is reported as the fault of the run
            let _ = run.check_invariants(false);
        })
    }

    /// Forgets the step done last, and keeps what was counted.
    pub(crate) fn forget_last_step(&mut self) {
        self.scratch.begin(0);
        self.scratch.updates.begin(self.state.len());
    }

    /// The step done last, or failed; its update set is empty before the first one.
    pub fn last_step(&self) -> Step<'_> {
        Step { machine: self }
    }

    /// What the chooser picked in the last step, by the place of the variable's range.
    pub(crate) fn picked(&self) -> &[(Origin, Value)] {
        &self.scratch.record.picked
    }

    /// How often what [`asmotion_ir::Program::counted`] lists ran; steps that failed count, too.
    pub fn counts(&self) -> Vec<u64> {
        let record = &self.scratch.record;
        let counters = 0..self.program.counted.len() as u32;
        counters.map(|counter| record.counted(counter)).collect()
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
        *is_plain = plain::fire(&updates.list, slots, before);
        for &(domain, atom) in &updates.extended {
            for &domain in &self.code.supers[domain.0 as usize] {
                Arc::make_mut(&mut self.state.store.extents[domain.0 as usize])
                    .push(Value::Atom(atom));
            }
        }
    }

    /// Does some work with code at hand.
    #[inline]
    pub(crate) fn run<T>(
        &mut self,
        environment: &mut dyn Environment,
        chooser: &mut dyn Chooser,
        step: u64,
        now_ns: i64,
        work: impl FnOnce(&mut StepContext<'_>) -> T,
    ) -> Result<T, Box<StepFault>> {
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
            post: &self.post,
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
