//! The context in which compiled code runs during a step.

pub(crate) mod code;

use crate::bounds::is_bounded;
use crate::choose::Chooser;
use crate::environment::Environment;
use crate::fault::{FaultKind, StepFault};
use crate::limits::{MAX_CALLS, MAX_DEPTH, MAX_ITERATIONS};
use crate::messages::MessagesInTransit;
use crate::misfit::DomainMisfit;
use crate::record::{StepInput, StepLog};
use crate::run::code::CompiledProgram;
use crate::state::{MachineState, dense};
use crate::updates::{Layer, Updates, WritableState};
use crate::witness_notes::WitnessNotes;
use asmotion_ir::{
    BodyId, DomainId, Function, FunctionId, FunctionKind, Local, Origin, Program, RoutineId, Slot,
};
use asmotion_value::Value;

/// Stack space, in bytes, that suffices for one body: the nesting of its terms is limited.
const FRAME: usize = 512 * 1024;

/// Runs `work`, on a new stack segment if the current one is nearly exhausted.
pub fn on_enough_stack<T>(work: impl FnOnce() -> T) -> T {
    stacker::maybe_grow(FRAME, 4 * FRAME, work)
}

/// The values that a function's codomain admits.
#[derive(Clone, Copy)]
enum Restriction {
    /// All values of its shape.
    None,
    /// The elements of a domain.
    Domain(DomainId),
    /// Those of which certain parts are elements of domains.
    Parts,
}

impl Restriction {
    fn of(program: &Program, declared: &Function) -> Self {
        match declared.within {
            Some(domain) => Self::Domain(domain),
            // the reference checks no parts
            None if declared.restricted && !program.compatible => Self::Parts,
            None => Self::None,
        }
    }
}

/// The checks for updates of a function's locations.
#[derive(Clone, Copy)]
pub(crate) struct CodomainCheck {
    function: FunctionId,
    restriction: Restriction,
    /// `true` if arguments must be checked for membership in concrete domains.
    narrow: bool,
    open: bool,
}

impl CodomainCheck {
    pub fn of(program: &Program, function: FunctionId) -> Self {
        let declared = &program.functions[function.0 as usize];
        Self {
            function,
            restriction: Restriction::of(program, declared),
            narrow: declared.narrow && !program.compatible,
            open: declared.open,
        }
    }
}

/// A rule stopped; the context holds the fault.
#[derive(Debug)]
pub struct RuleStopped;

/// A truth value of strong Kleene logic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KleeneTruth {
    /// The Boolean value `false`.
    False,
    /// The Boolean value `true`.
    True,
    /// Undef: neither true nor false.
    Undef,
}

impl KleeneTruth {
    /// Converts a `bool`.
    pub fn of(truth: bool) -> Self {
        if truth { Self::True } else { Self::False }
    }

    /// Converts to a value of the language.
    pub fn value(self) -> Value {
        match self {
            Self::False => Value::Bool(false),
            Self::True => Value::Bool(true),
            Self::Undef => Value::Undef,
        }
    }

    /// Converts a value of the language; all values but truth values become undef.
    pub fn from_value(value: &Value) -> Self {
        if let Value::Bool(truth) = value {
            Self::of(*truth)
        } else {
            Self::Undef
        }
    }
}

/// The context of a step in progress.
///
/// A term that fails records the reason in `fault` and returns undef; rules check `fault` before
/// they continue. Terms therefore need no result type of their own, and a failed step writes
/// nothing.
pub struct StepContext<'a> {
    pub(crate) program: &'a Program,
    pub(crate) code: &'a CompiledProgram,
    pub(crate) state: &'a mut MachineState,
    pub(crate) updates: &'a mut Updates,
    pub(crate) environment: &'a mut dyn Environment,
    pub(crate) messages: &'a MessagesInTransit,
    pub(crate) chooser: &'a mut dyn Chooser,
    pub(crate) record: &'a mut StepLog,
    /// The frames of all active routines and bodies, outermost first.
    pub locals: &'a mut Vec<Value>,
    /// Arguments of locations and library functions while they are evaluated.
    pub(crate) stack: &'a mut Vec<Value>,
    /// Start of the innermost frame in `locals`.
    pub base: usize,
    /// The running agent (`self`), undef outside of agents' programs.
    pub agent: Value,
    /// Nesting depth of calls.
    pub depth: u32,
    /// Number of active runs with local state; identifies the innermost one.
    pub(crate) runs: i64,
    /// Number of calls of bodies and routines in this step.
    pub calls: u32,
    /// Number of loop iterations in this step.
    pub iterations: u32,
    /// Number of variables bound in this step.
    pub bindings: u32,
    pub(crate) step: u64,
    /// The current attempt: inputs marked with this number are valid.
    pub(crate) round: u64,
    pub(crate) now_ns: i64,
    /// `true` while the initial state is computed, during which it is the current state.
    pub(crate) building: bool,
    /// `true` while a term is evaluated in the state before the step.
    pub(crate) is_before: bool,
    pub(crate) fault: Option<Box<StepFault>>,
    /// `true` if evaluating the failed term again would not fail again: a location whose initial value failed is known by then.
    pub(crate) is_fault_final: bool,
    /// Destination of recording code; `None` in a normal step.
    pub(crate) notes: &'a mut Option<WitnessNotes>,
}

impl StepContext<'_> {
    /// Returns the limit for loop iterations in this step.
    pub(crate) fn max_iterations(&self) -> u32 {
        match &self.notes {
            Some(notes) => notes.max_iterations(),
            None => MAX_ITERATIONS,
        }
    }

    /// Records the reason for the step's failure, unless one was recorded before. Returns undef,
    /// the value of a failed term.
    #[cold]
    pub fn fail(&mut self, kind: FaultKind, origin: Origin) -> Value {
        if self.fault.is_none() {
            let fault = StepFault {
                kind,
                origin,
                agent: self.agent.clone(),
                step: self.step,
            };
            self.fault = Some(Box::new(fault));
            if let Some(notes) = self.notes {
                notes.fail();
            }
        }
        Value::Undef
    }

    #[cold]
    pub(crate) fn stop(&mut self, kind: FaultKind, origin: Origin) -> RuleStopped {
        self.fail(kind, origin);
        RuleStopped
    }

    /// Returns an error if a term has failed.
    pub(crate) fn checked(&self) -> Result<(), RuleStopped> {
        if self.fault.is_none() {
            Ok(())
        } else {
            Err(RuleStopped)
        }
    }

    pub(crate) fn local(&self, local: Local) -> &Value {
        &self.locals[self.base + local as usize]
    }

    pub(crate) fn set_local(&mut self, local: Local, value: Value) {
        self.locals[self.base + local as usize] = value;
    }

    /// Returns the value of an input location in this step.
    pub(crate) fn input(&mut self, slot: Slot, function: FunctionId, origin: Origin) -> Value {
        let index = slot as usize;
        // the initial state depends on the inputs of the first step only
        let is_past = self.building && self.step > 1;
        if is_past || self.state.memo.read_in[index] == self.round {
            return self.state.store.slots[index].clone();
        }
        let declared = &self.program.functions[function.0 as usize];
        let from = self.stack.len();
        self.state.arguments(self.program, slot, self.stack);
        if let (Some(mail), Some(messages)) = (declared.mail, &self.program.messages) {
            return self.message_query(slot, mail, messages, from);
        }
        let answer = self.answer(slot, function, from);
        self.stack.truncate(from);
        // whatever the answer, the environment is asked only once in a round
        self.record_read(slot);
        let value = match (answer, declared.clock) {
            (Ok(Some(value)), _) => Some(value),
            (Ok(None), Some(unit)) => Some(Value::Int(self.now_ns.div_euclid(unit))),
            (Ok(None), None) => {
                let is_undef =
                    declared.kind == FunctionKind::Monitored && declared.initial.is_none();
                is_undef.then_some(Value::Undef)
            }
            (Err(kind), _) => return self.fail(kind, origin),
        };
        let Some(value) = value else {
            return self.state.store.slots[index].clone();
        };
        self.record.inputs.push(StepInput {
            slot,
            value: value.clone(),
        });
        self.state.store.slots[index] = value.clone();
        if self.step <= 1 {
            self.state.set_initial(slot, value.clone());
        }
        value
    }

    /// Asks the environment for the value of a location whose arguments are on the stack from
    /// `arguments` on.
    fn answer(
        &mut self,
        slot: Slot,
        function: FunctionId,
        arguments: usize,
    ) -> Result<Option<Value>, FaultKind> {
        let arguments = &self.stack[arguments..];
        let answer = self.environment.read(function, arguments);
        let answer = answer.map_err(|reason| FaultKind::Input { slot, reason })?;
        match answer
            .as_ref()
            .and_then(|value| self.misfit(function, value))
        {
            None => Ok(answer),
            Some(misfit) => Err(FaultKind::OutsideInput {
                slot,
                misfit,
                source: self.environment.source(function, arguments),
            }),
        }
    }

    /// Records that the environment was asked, which happens once in a step. The reference forgets
    /// this together with the intermediate state in which it asked.
    pub(crate) fn record_read(&mut self, slot: Slot) {
        let before = std::mem::replace(&mut self.state.memo.read_in[slot as usize], self.round);
        if self.program.compatible {
            self.updates.undo_read(slot, before);
        }
    }

    /// Returns the slot of a location whose arguments are on the stack from `arguments` on.
    pub(crate) fn slot(&mut self, function: FunctionId, arguments: usize) -> Slot {
        if let Some(slot) = dense(self.program, function, &self.stack[arguments..]) {
            if !self.state.locations.is_materialised(slot) {
                let value = self.first_value(function, arguments);
                self.state.materialise(slot, value);
            }
            return slot;
        }
        if let Some(slot) = self
            .state
            .locations
            .find(function, &self.stack[arguments..])
        {
            return slot;
        }
        let value = self.first_value(function, arguments);
        let outside = self.misplaced(function, arguments).is_some();
        let arguments: Vec<Value> = self.stack[arguments..].to_vec();
        let slot = self.state.intern(function, &arguments, value, outside);
        self.updates.grow(self.state.store.slots.len());
        slot
    }

    /// Returns the initial value of a location on first access.
    fn first_value(&mut self, function: FunctionId, arguments: usize) -> Value {
        let Some(body) = self.program.functions[function.0 as usize].initial else {
            return Value::Undef;
        };
        let value = self.initial_value(body, arguments);
        self.is_fault_final |= self.fault.is_some();
        value
    }

    /// Evaluates the body of an initial value in the initial state, with arguments from the stack.
    fn initial_value(&mut self, body: BodyId, arguments: usize) -> Value {
        let from = self.locals.len();
        self.locals.extend_from_slice(&self.stack[arguments..]);
        if self.building || self.program.compatible {
            return self.call_body(body, from);
        }
        let agent = std::mem::take(&mut self.agent);
        let now_ns = std::mem::replace(&mut self.now_ns, self.state.initial.now_ns);
        self.swap_initial();
        self.building = true;
        let value = self.call_body(body, from);
        self.building = false;
        self.swap_initial();
        self.now_ns = now_ns;
        self.agent = agent;
        value
    }

    /// Swaps the current state with the initial one.
    fn swap_initial(&mut self) {
        let state = &mut *self.state;
        std::mem::swap(&mut state.store.slots, &mut state.initial.slots);
        std::mem::swap(&mut state.store.extents, &mut state.initial.extents);
    }

    /// Evaluates a body whose arguments are the locals from `from` on.
    pub(crate) fn call_body(&mut self, body: BodyId, from: usize) -> Value {
        let code = self.code;
        let body = &code.bodies[body.0 as usize];
        if !self.enter(body.origin) {
            self.locals.truncate(from);
            return Value::Undef;
        }
        self.locals
            .resize(from + body.locals as usize, Value::Undef);
        if body.open {
            self.bound_arguments(from, body.arguments, body.origin);
        }
        let outer = std::mem::replace(&mut self.base, from);
        let mut value = on_enough_stack(|| (body.code)(self));
        if body.open && !is_bounded(&value) {
            value = self.fail(FaultKind::Unbounded, body.origin);
        }
        self.base = outer;
        self.locals.truncate(from);
        self.depth -= 1;
        value
    }

    /// Fails if an argument exceeds the limits for values.
    fn bound_arguments(&mut self, from: usize, count: u32, origin: Origin) {
        if !self
            .locals
            .iter()
            .skip(from)
            .take(count as usize)
            .all(is_bounded)
        {
            self.fail(FaultKind::Unbounded, origin);
        }
    }

    /// Runs the main rule at the start of a step, and checks the assumptions about inputs.
    #[inline]
    pub(crate) fn main_rule(&mut self, is_native: bool) -> Result<(), RuleStopped> {
        match self.program.main {
            Some(main) => self.call_main(main, is_native)?,
            None => return Err(self.stop(FaultKind::NoMain, Origin::default())),
        }
        self.check_invariants(true)
    }

    /// Runs the main rule at the start of a step.
    #[inline]
    fn call_main(&mut self, main: RoutineId, is_native: bool) -> Result<(), RuleStopped> {
        let code = self.code;
        let Some(Ok(native)) = code.native.get().filter(|_| is_native) else {
            return self.call_routine(main, 0);
        };
        (self.calls, self.depth) = (1, 1);
        let done = native.run(self);
        self.locals.clear();
        self.depth = 0;
        done
    }

    /// Runs a routine whose arguments are the locals from `from` on.
    pub(crate) fn call_routine(
        &mut self,
        routine: RoutineId,
        from: usize,
    ) -> Result<(), RuleStopped> {
        let code = self.code;
        let routine = &code.routines[routine.0 as usize];
        if !self.enter(routine.origin) {
            self.locals.truncate(from);
            return Err(RuleStopped);
        }
        self.locals
            .resize(from + routine.locals as usize, Value::Undef);
        if routine.open {
            self.bound_arguments(from, routine.arguments, routine.origin);
        }
        let outer = std::mem::replace(&mut self.base, from);
        let done = self
            .checked()
            .and_then(|()| on_enough_stack(|| (routine.code)(self)));
        self.base = outer;
        self.locals.truncate(from);
        self.depth -= 1;
        done
    }

    fn enter(&mut self, origin: Origin) -> bool {
        if self.fault.is_some() {
            return false;
        }
        if self.depth >= MAX_DEPTH {
            self.fail(FaultKind::TooDeep(MAX_DEPTH), origin);
            return false;
        }
        if self.calls >= MAX_CALLS {
            self.fail(FaultKind::ManyCalls(MAX_CALLS), origin);
            return false;
        }
        self.calls += 1;
        self.depth += 1;
        true
    }

    /// Adds an update after checking its value.
    pub(crate) fn write(
        &mut self,
        slot: Slot,
        value: Value,
        codomain: CodomainCheck,
        origin: Origin,
    ) -> Result<(), RuleStopped> {
        self.accepts(slot, &value, codomain, origin)?;
        match self.updates.write(slot, value, origin) {
            Ok(()) => Ok(()),
            Err(clash) => Err(self.stop(*clash, origin)),
        }
    }

    /// Checks that a location may receive a value.
    #[inline]
    pub(crate) fn accepts(
        &mut self,
        slot: Slot,
        value: &Value,
        codomain: CodomainCheck,
        origin: Origin,
    ) -> Result<(), RuleStopped> {
        self.checked()?;
        match codomain.restriction {
            Restriction::None => {}
            Restriction::Domain(domain) => {
                if !value.is_undef() && !self.is_element(domain, value) {
                    let misfit = DomainMisfit::whole(codomain.function, value, domain);
                    return Err(self.stop(FaultKind::Outside { slot, misfit }, origin));
                }
            }
            Restriction::Parts => {
                if let Some(misfit) = self.misfit_of_parts(codomain.function, value) {
                    return Err(self.stop(FaultKind::Outside { slot, misfit }, origin));
                }
            }
        }
        if codomain.narrow {
            self.check_place(slot, origin)?;
        }
        if codomain.open && !is_bounded(value) {
            return Err(self.stop(FaultKind::Unbounded, origin));
        }
        Ok(())
    }

    fn written(&mut self) -> (&mut Updates, WritableState<'_>) {
        let state = &mut *self.state;
        let written = WritableState {
            slots: &mut state.store.slots,
            extents: &mut state.store.extents,
            read_in: &mut state.memo.read_in,
            round: self.round,
            supers: &self.code.supers,
        };
        (self.updates, written)
    }

    pub(crate) fn apply(&mut self, layer: Layer) {
        let (updates, mut written) = self.written();
        updates.close_applying(layer, &mut written);
    }

    /// Adds an update within a sequence and applies it immediately.
    pub fn write_through(&mut self, slot: Slot, value: Value, origin: Origin) {
        let (updates, mut written) = self.written();
        updates.write_through(slot, value, origin, &mut written);
    }

    /// Evaluates a term in the state before the step.
    pub(crate) fn in_previous_state(&mut self, term: &dyn Fn(&mut Self) -> Value) -> Value {
        if std::mem::replace(&mut self.is_before, true) {
            return term(self);
        }
        let (updates, mut written) = self.written();
        let passed = updates.rewind(&mut written);
        let value = term(self);
        let (updates, mut written) = self.written();
        updates.fast_forward(passed, &mut written);
        self.is_before = false;
        value
    }

    pub(crate) fn restore(&mut self, layer: Layer) -> Result<(), RuleStopped> {
        let (updates, mut written) = self.written();
        match updates.close_sequence(layer, &mut written) {
            Ok(()) => Ok(()),
            Err((clash, origin)) => Err(self.stop(clash, origin)),
        }
    }

    /// Runs a turbo rule and returns the value it wrote to `result`, which is hidden from its
    /// caller.
    pub(crate) fn taking_result(
        &mut self,
        work: impl FnOnce(&mut Self) -> Result<(), RuleStopped>,
    ) -> Result<Value, RuleStopped> {
        let result = self.program.result;
        let leaks = self.program.compatible;
        let layer = self.updates.open();
        if !leaks {
            let (updates, mut written) = self.written();
            updates.hide(result, Value::Undef, &mut written);
        }
        work(self)?;
        let value = self
            .updates
            .written_value(result)
            .cloned()
            .unwrap_or_default();
        let (updates, mut written) = self.written();
        match updates.close_restoring(layer, &mut written, |slot| slot == result && !leaks) {
            Ok(()) => Ok(value),
            Err((clash, origin)) => Err(self.stop(clash, origin)),
        }
    }

    /// Runs a rule with local state: first the initialisation, then the body, under a new run
    /// number. The local locations are hidden from the caller.
    pub(crate) fn with_state(
        &mut self,
        number: Local,
        initial: impl FnOnce(&mut Self) -> Result<(), RuleStopped>,
        body: impl FnOnce(&mut Self) -> Result<(), RuleStopped>,
    ) -> Result<(), RuleStopped> {
        self.runs += 1;
        let runs = self.runs;
        self.set_local(number, Value::Int(runs));
        let sequence = self.updates.open();
        let layer = self.updates.open();
        initial(self)?;
        self.apply(layer);
        let layer = self.updates.open();
        body(self)?;
        self.apply(layer);
        self.runs -= 1;
        let state = &mut *self.state;
        let locations = &state.locations;
        let mut written = WritableState {
            slots: &mut state.store.slots,
            extents: &mut state.store.extents,
            read_in: &mut state.memo.read_in,
            round: self.round,
            supers: &self.code.supers,
        };
        let is_local = |slot| locations.is_local(self.program, slot, runs);
        match self
            .updates
            .close_restoring(sequence, &mut written, is_local)
        {
            Ok(()) => Ok(()),
            Err((clash, origin)) => Err(self.stop(clash, origin)),
        }
    }

    #[cold]
    pub(crate) fn abandon(&mut self, grown: (usize, usize)) {
        let (updates, mut written) = self.written();
        updates.abandon(grown, &mut written);
    }
}
