//! A session with undo, which also records the last writer of each location.

use crate::guards::PassedGuard;
use crate::session::Session;
use asmotion_diagnostics::Report;
use asmotion_ir::{AddedTerm, FunctionId, FunctionKind, Origin, Slot};
use asmotion_machine::{Environment, Machine, StepFault};
use asmotion_simulate::{ConstrainedInputs, InputValues, Random, RecordedStep, Recording, Seeded};
use asmotion_value::Value;
use std::collections::BTreeMap;

/// A session together with all its events.
pub struct History {
    session: Session,
    present: SessionState,
    events: Vec<HistoryEvent>,
    /// Snapshots taken before some of the events, by event number. The first and the most recent
    /// ones are always included.
    moments: BTreeMap<usize, SessionSnapshot>,
    /// Inputs, choices and times of the first steps, as long as nothing else happens.
    recording: Recording,
}

/// Number of most recent snapshots that are kept. Of older ones, one in this number is kept.
const KEPT: usize = 64;

/// Duration of a step: one second.
const STEP_NS: i64 = 1_000_000_000;

/// The state of a session outside the machine.
#[derive(Clone)]
struct SessionState {
    inputs: UserInputs,
    choices: Seeded,
    written: BTreeMap<Slot, LastWrite>,
}

#[derive(Clone)]
struct SessionSnapshot {
    machine: Machine,
    present: SessionState,
}

/// An event of a session.
#[derive(Clone, Debug, PartialEq)]
pub enum HistoryEvent {
    /// A step of the main rule.
    Step,
    /// Firing of a rule, given as text.
    Fire(String),
    /// Assignment of a value from outside; a monitored location keeps it for all later steps.
    Set(FunctionId, Vec<Value>, Value),
    /// A monitored location no longer has a held value.
    Release(FunctionId, Vec<Value>),
}

/// The last write to a location.
#[derive(Clone, Debug, PartialEq)]
pub struct LastWrite {
    /// Number of the event, from 0.
    pub event: usize,
    /// Number of steps completed before it.
    pub steps: u64,
    /// Place of the update; `None` for a fired rule and for an assignment from outside.
    pub origin: Option<Origin>,
    /// Previous value of the location.
    pub before: Value,
    /// New value of the location.
    pub after: Value,
}

/// Inputs that keep their value until they are set again or released.
#[derive(Clone)]
struct UserInputs {
    values: InputValues,
    /// Source of all other inputs; `None` makes them undef.
    otherwise: Option<Box<Random>>,
}

impl UserInputs {
    /// Executes a step, with random inputs that satisfy the constraints of the specification together with the held ones.
    fn step(
        &mut self,
        machine: &mut Machine,
        choices: &mut Seeded,
        now_ns: i64,
    ) -> Result<(), Box<StepFault>> {
        let drawn = match &mut self.otherwise {
            Some(random) => random.constrained_inputs(machine, &self.values, now_ns)?,
            None => InputValues::new(),
        };
        let mut inputs = ConstrainedInputs::new(drawn, self);
        machine.step(&mut inputs, choices, now_ns).map(|_| ())
    }
}

impl Environment for UserInputs {
    fn read(&mut self, function: FunctionId, arguments: &[Value]) -> Result<Option<Value>, String> {
        match (
            self.values.get(&(function, arguments.to_vec())),
            &mut self.otherwise,
        ) {
            (Some(value), _) => Ok(Some(value.clone())),
            (None, Some(random)) => random.read(function, arguments),
            (None, None) => Ok(None),
        }
    }

    fn source(&self, _function: FunctionId, _arguments: &[Value]) -> String {
        "a `set`".to_owned()
    }
}

impl History {
    /// Starts with the current state of a session. The seed determines choices and, if `is_random`
    /// is set, the inputs that are not held.
    pub fn new(session: Session, seed: u64, is_random: bool) -> Self {
        let random = || {
            let program = session.specification.program.clone();
            Box::new(Random::new(program, &session.machine, seed))
        };
        let present = SessionState {
            inputs: UserInputs {
                values: InputValues::new(),
                otherwise: is_random.then(random),
            },
            choices: Seeded::new(seed),
            written: BTreeMap::new(),
        };
        Self {
            session,
            present,
            events: Vec::new(),
            moments: BTreeMap::new(),
            recording: Recording::default(),
        }
    }

    /// Starts a history whose first steps have the inputs, choices and times of a recording. It is left when a location is set or
    /// a rule is fired, and continued when that is undone.
    pub fn of_recording(
        session: Session,
        seed: u64,
        is_random: bool,
        recording: Recording,
    ) -> Self {
        Self {
            recording,
            ..Self::new(session, seed, is_random)
        }
    }

    /// Returns the number of recorded steps.
    pub fn recorded(&self) -> usize {
        self.recording.steps().len()
    }

    /// Returns `true` if the next step is a recorded one.
    pub fn is_recorded(&self) -> bool {
        self.recorded_step().is_some()
    }

    fn recorded_step(&self) -> Option<&RecordedStep> {
        let is_step = |event: &HistoryEvent| *event == HistoryEvent::Step;
        let steps = usize::try_from(self.session.machine.steps()).ok()?;
        let next = self.recording.steps().get(steps)?;
        self.events.iter().all(is_step).then_some(next)
    }

    /// Returns the specification and its machine in the current state.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// Returns the events that were not undone, in order.
    pub fn events(&self) -> &[HistoryEvent] {
        &self.events
    }

    /// Iterates over the monitored locations with a held value.
    pub fn held(&self) -> impl Iterator<Item = (FunctionId, &[Value], &Value)> {
        let held = self.present.inputs.values.iter();
        held.map(|((function, arguments), value)| (*function, arguments.as_slice(), value))
    }

    /// Adds a term for repeated evaluation.
    ///
    /// # Errors
    /// The text is not a term, or it does not fit the specification.
    pub fn watch(&mut self, text: &str) -> Result<AddedTerm, Report> {
        self.session.watch(text)
    }

    /// Evaluates a watched term in the current state.
    ///
    /// # Errors
    /// The evaluation fails.
    pub fn value(&mut self, term: AddedTerm) -> Result<Value, Report> {
        let mut inputs = self.present.inputs.clone();
        let now_ns = self.now();
        self.session.value(term, &mut inputs, now_ns)
    }

    /// Evaluates a term in the current state.
    ///
    /// # Errors
    /// The text is not a term, it does not fit the specification, or its evaluation fails.
    pub fn evaluate(&mut self, text: &str) -> Result<Value, Report> {
        let mut inputs = self.present.inputs.clone();
        let now_ns = self.now();
        self.session.evaluate(text, &mut inputs, now_ns)
    }

    /// Enables coverage counters: see [`Session::count`].
    ///
    /// # Errors
    /// The program cannot be lowered again; it is unchanged.
    pub fn count(&mut self) -> Result<(), Report> {
        self.session.count()
    }

    /// Executes a step of the main rule and records it as an event.
    ///
    /// # Errors
    /// The step has no next state. Nothing has changed, except after a violated invariant of the
    /// new state.
    pub fn step(&mut self) -> Result<(), Report> {
        self.happen(HistoryEvent::Step)
    }

    /// Fires a rule, which is not a step.
    ///
    /// # Errors
    /// The text is not a rule, it does not fit the specification, or the rule fails. Nothing has
    /// changed.
    pub fn fire(&mut self, rule: &str) -> Result<(), Report> {
        self.happen(HistoryEvent::Fire(rule.to_owned()))
    }

    /// Executes `location := value`: holds a monitored location for all later steps, or updates any
    /// other location once.
    ///
    /// # Errors
    /// The text is not an assignment, it does not fit the specification, or the function is static or
    /// derived.
    pub fn set(&mut self, assignment: &str) -> Result<(), Report> {
        let mut inputs = self.present.inputs.clone();
        let now_ns = self.now();
        let found = self.session.assignment(assignment, &mut inputs, now_ns)?;
        let (function, arguments, value) = found;
        self.happen(HistoryEvent::Set(function, arguments, value))
    }

    /// Stops holding a monitored location, written as in `battery(ROB1)`.
    ///
    /// # Errors
    /// The text is not a location of the specification.
    pub fn release(&mut self, location: &str) -> Result<(), Report> {
        let (function, arguments) = self.location(location)?;
        self.happen(HistoryEvent::Release(function, arguments))
    }

    /// Returns the function and the arguments of a location, written as in `battery(ROB1)`.
    ///
    /// # Errors
    /// The text is not a location of the specification.
    pub fn location(&mut self, text: &str) -> Result<(FunctionId, Vec<Value>), Report> {
        let mut inputs = self.present.inputs.clone();
        let assignment = format!("{text} := undef");
        let now_ns = self.now();
        let found = self.session.assignment(&assignment, &mut inputs, now_ns)?;
        Ok((found.0, found.1))
    }

    /// Returns the last write to a location, or `None` if it has its initial value.
    pub fn written(&self, function: FunctionId, arguments: &[Value]) -> Option<&LastWrite> {
        let machine = &self.session.machine;
        let slot = machine
            .state()
            .slot(machine.program(), function, arguments)?;
        self.present.written.get(&slot)
    }

    /// Returns the guards on the way to the last write of a location, outermost first; none unless a step wrote it.
    pub fn guards(&mut self, function: FunctionId, arguments: &[Value]) -> Vec<PassedGuard> {
        let written = self.written(function, arguments).map(|it| it.event);
        let is_step = |number: &usize| self.events.get(*number) == Some(&HistoryEvent::Step);
        let Some(number) = written.filter(is_step) else {
            return Vec::new();
        };
        let events = self.events.get(number..).unwrap_or_default().to_vec();
        self.go_to(number);
        let before = self.session.machine.clone();
        let mut guards = Vec::new();
        for (index, event) in events.into_iter().enumerate() {
            // an event that failed fails again, and is part of the history
            let _ = self.happen(event);
            if index == 0 {
                guards = self.guards_of_last_step(&before, function, arguments);
            }
        }
        guards
    }

    /// The guards on the way to the update of a location in the last step.
    fn guards_of_last_step(
        &self,
        before: &Machine,
        function: FunctionId,
        arguments: &[Value],
    ) -> Vec<PassedGuard> {
        let Session {
            machine,
            specification,
            ..
        } = &self.session;
        specification.guards_of_update(machine, before, function, arguments)
    }

    /// Undoes up to `count` events; returns how many were undone.
    pub fn undo(&mut self, count: usize) -> usize {
        let target = self.events.len().saturating_sub(count);
        let undone = self.events.len() - target;
        self.go_to(target);
        undone
    }

    /// Repeats all events from the beginning, and calls `show` after each.
    pub fn replay(&mut self, mut show: impl FnMut(&HistoryEvent, &Session)) {
        let events = self.events.clone();
        self.go_to(0);
        for event in events {
            // an event that failed fails again, and is part of the history
            let _ = self.happen(event.clone());
            show(&event, &self.session);
        }
    }

    /// Returns the time: one second for each completed step.
    fn now(&self) -> i64 {
        let steps = i64::try_from(self.session.machine.steps()).unwrap_or(i64::MAX);
        steps.saturating_mul(STEP_NS)
    }

    fn go_to(&mut self, target: usize) {
        let Some((&near, moment)) = self.moments.range(..=target).next_back() else {
            return;
        };
        let moment = moment.clone();
        let program = self.session.specification.program.clone();
        self.session.machine = moment.machine;
        // cannot fail: only terms were added since, and no locations
        let _ = self.session.machine.replace_program(program);
        self.present = moment.present;
        let again = self.events.split_off(near);
        self.moments.split_off(&near);
        for event in again.into_iter().take(target - near) {
            let _ = self.happen(event);
        }
    }

    fn happen(&mut self, event: HistoryEvent) -> Result<(), Report> {
        let number = self.events.len();
        let moment = SessionSnapshot {
            machine: self.session.machine.clone(),
            present: self.present.clone(),
        };
        let has_messages = self.recorded_step().is_some_and(RecordedStep::has_messages);
        let done = self.apply(&event);
        let steps = moment.machine.steps();
        if done.is_err() && self.session.machine.steps() == steps {
            if has_messages {
                // a retry delivers them again
                self.session.machine = moment.machine;
            }
            // the machine has kept its state; restoring the generators lets a retry draw the same
            // values
            self.present = moment.present;
            return done;
        }
        self.moments.insert(number, moment);
        if let Some(old) = number.checked_sub(KEPT)
            && old % KEPT != 0
        {
            self.moments.remove(&old);
        }
        self.events.push(event);
        done
    }

    fn apply(&mut self, event: &HistoryEvent) -> Result<(), Report> {
        let now_ns = self.now();
        let recorded = self.recorded_step().cloned();
        let recorded = recorded.filter(|_| *event == HistoryEvent::Step);
        let recorded = recorded.and_then(|step| {
            let machine = &mut self.session.machine;
            // values that do not fit, because the specification was edited, are missing
            let (inputs, _) = step.readable_inputs(machine);
            step.deliver(machine).ok()?;
            Some((inputs, step.choices(), step.now_ns))
        });
        let SessionState {
            inputs, choices, ..
        } = &mut self.present;
        match event {
            HistoryEvent::Step => {
                let done = match recorded {
                    Some((mut inputs, mut choices, now_ns)) => {
                        let machine = &mut self.session.machine;
                        let done = machine.step(&mut inputs, &mut choices, now_ns);
                        done.map(|_| ())
                    }
                    None => {
                        let machine = &mut self.session.machine;
                        inputs.step(machine, choices, now_ns + STEP_NS)
                    }
                };
                let done = done.map_err(|fault| self.report(&fault));
                self.note_updates(true);
                done
            }
            HistoryEvent::Fire(rule) => {
                self.session.fire(rule, inputs, choices, now_ns)?;
                // the rule is removed from the program, and its origins with it
                self.note_updates(false);
                Ok(())
            }
            HistoryEvent::Set(function, arguments, value) => {
                self.set_location(*function, arguments, value)
            }
            HistoryEvent::Release(function, arguments) => {
                inputs.values.remove(&(*function, arguments.clone()));
                Ok(())
            }
        }
    }

    fn set_location(
        &mut self,
        function: FunctionId,
        arguments: &[Value],
        value: &Value,
    ) -> Result<(), Report> {
        let machine = &mut self.session.machine;
        let program = machine.program().clone();
        match program.functions[function.0 as usize].kind {
            FunctionKind::Monitored => {
                let key = (function, arguments.to_vec());
                self.present.inputs.values.insert(key, value.clone());
                Ok(())
            }
            FunctionKind::Controlled | FunctionKind::Shared | FunctionKind::Out => {
                let known = machine.state().slot(&program, function, arguments);
                let before = known.map_or(Value::Undef, |slot| machine.state().get(slot).clone());
                let slot = match machine.set(function, arguments, value.clone()) {
                    Ok(slot) => slot,
                    Err(fault) => return Err(self.report(&fault)),
                };
                self.note(slot, None, before, value.clone());
                Ok(())
            }
            // rejected when the text was resolved
            FunctionKind::Fixed | FunctionKind::Local => Ok(()),
        }
    }

    fn note_updates(&mut self, has_places: bool) {
        let step = self.session.machine.last_step();
        let updates: Vec<_> = step
            .updates()
            .iter()
            .zip(step.before())
            .map(|(update, before)| {
                (
                    update.slot,
                    update.origin,
                    before.clone(),
                    update.value.clone(),
                )
            })
            .collect();
        for (slot, origin, before, after) in updates {
            self.note(slot, has_places.then_some(origin), before, after);
        }
    }

    fn note(&mut self, slot: Slot, origin: Option<Origin>, before: Value, after: Value) {
        let written = LastWrite {
            event: self.events.len(),
            steps: self.session.machine.steps(),
            origin,
            before,
            after,
        };
        self.present.written.insert(slot, written);
    }

    fn report(&self, fault: &StepFault) -> Report {
        let mut report = Report::new();
        let session = &self.session;
        report.push(session.specification.explain_in(fault, &session.machine));
        report
    }
}
