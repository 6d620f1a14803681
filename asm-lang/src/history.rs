//! A session with a past: any number of events can be undone, and a location says who wrote it last.

use crate::session::Session;
use asmotion_diagnostics::Report;
use asmotion_ir::{AddedTerm, FunctionId, FunctionKind, Origin, Slot};
use asmotion_machine::{Environment, Machine, StepFault};
use asmotion_simulate::{Random, Seeded};
use asmotion_value::Value;
use std::collections::BTreeMap;

/// A session, and everything that happened in it.
pub struct History {
    session: Session,
    present: SessionState,
    events: Vec<HistoryEvent>,
    /// What was before some of the events, by their numbers: before the first, and all the way to now.
    moments: BTreeMap<usize, SessionSnapshot>,
}

/// So many moments are kept before now; of older ones, one in so many.
const KEPT: usize = 64;

/// A step takes a second.
const STEP_NS: i64 = 1_000_000_000;

/// What the machine does not know of itself.
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

/// What happened.
#[derive(Clone, Debug, PartialEq)]
pub enum HistoryEvent {
    /// A step.
    Step,
    /// A rule was fired.
    Fire(String),
    /// A location got a value from outside: a monitored one for all steps to come.
    Set(FunctionId, Vec<Value>, Value),
    /// A monitored location is no longer held.
    Release(FunctionId, Vec<Value>),
}

/// Who wrote a location last.
#[derive(Clone, Debug, PartialEq)]
pub struct LastWrite {
    /// The number of the event, from 0.
    pub event: usize,
    /// How many steps had been done then.
    pub steps: u64,
    /// The rule, if it was one.
    pub origin: Option<Origin>,
    /// What the location held before.
    pub before: Value,
    /// What it got.
    pub after: Value,
}

/// Inputs that hold until they are told otherwise.
#[derive(Clone)]
struct UserInputs {
    values: BTreeMap<(FunctionId, Vec<Value>), Value>,
    /// Answers what is not held; undef without it.
    otherwise: Option<Box<Random>>,
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
    /// Begins with the state a session is in. The seed decides choices, and inputs that nobody gave
    /// if they are to be random.
    pub fn new(session: Session, seed: u64, is_random: bool) -> Self {
        let random = || {
            let program = session.specification.program.clone();
            Box::new(Random::new(program, &session.machine, seed))
        };
        let present = SessionState {
            inputs: UserInputs {
                values: BTreeMap::new(),
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
        }
    }

    /// The specification and its machine now.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// What happened, in order.
    pub fn events(&self) -> &[HistoryEvent] {
        &self.events
    }

    /// The monitored locations that are held, and their values.
    pub fn held(&self) -> impl Iterator<Item = (FunctionId, &[Value], &Value)> {
        let held = self.present.inputs.values.iter();
        held.map(|((function, arguments), value)| (*function, arguments.as_slice(), value))
    }

    /// Reads a term that will be asked for again and again.
    ///
    /// # Errors
    /// The text is no term, or does not fit the specification.
    pub fn watch(&mut self, text: &str) -> Result<AddedTerm, Report> {
        self.session.watch(text)
    }

    /// The value of a watched term now.
    ///
    /// # Errors
    /// The term has no value.
    pub fn value(&mut self, term: AddedTerm) -> Result<Value, Report> {
        let mut inputs = self.present.inputs.clone();
        let now_ns = self.now();
        self.session.value(term, &mut inputs, now_ns)
    }

    /// The value of a term now.
    ///
    /// # Errors
    /// The text is no term, does not fit the specification, or has no value.
    pub fn evaluate(&mut self, text: &str) -> Result<Value, Report> {
        let mut inputs = self.present.inputs.clone();
        let now_ns = self.now();
        self.session.evaluate(text, &mut inputs, now_ns)
    }

    /// From now on, counts what runs: see [`Session::count`].
    ///
    /// # Errors
    /// The program cannot be lowered anew; it is as before.
    pub fn count(&mut self) -> Result<(), Report> {
        self.session.count()
    }

    /// Does a step.
    ///
    /// # Errors
    /// It has no next state; then nothing happened, but for an invariant that the new state violates.
    pub fn step(&mut self) -> Result<(), Report> {
        self.happen(HistoryEvent::Step)
    }

    /// Fires a rule. It counts as no step.
    ///
    /// # Errors
    /// The text is no rule, does not fit the specification, or fails: nothing happened.
    pub fn fire(&mut self, rule: &str) -> Result<(), Report> {
        self.happen(HistoryEvent::Fire(rule.to_owned()))
    }

    /// Sets `location := value`: a monitored location for all steps to come, another one now.
    ///
    /// # Errors
    /// The text is no such thing, does not fit the specification, or the location is computed.
    pub fn set(&mut self, assignment: &str) -> Result<(), Report> {
        let mut inputs = self.present.inputs.clone();
        let now_ns = self.now();
        let found = self.session.assignment(assignment, &mut inputs, now_ns)?;
        let (function, arguments, value) = found;
        self.happen(HistoryEvent::Set(function, arguments, value))
    }

    /// No longer holds a monitored location; the text says it as in `battery(ROB1)`.
    ///
    /// # Errors
    /// The text is no location of the specification.
    pub fn release(&mut self, location: &str) -> Result<(), Report> {
        let (function, arguments) = self.location(location)?;
        self.happen(HistoryEvent::Release(function, arguments))
    }

    /// The function and the arguments of a location, as in `battery(ROB1)`.
    ///
    /// # Errors
    /// The text is no location of the specification.
    pub fn location(&mut self, text: &str) -> Result<(FunctionId, Vec<Value>), Report> {
        let mut inputs = self.present.inputs.clone();
        let assignment = format!("{text} := undef");
        let now_ns = self.now();
        let found = self.session.assignment(&assignment, &mut inputs, now_ns)?;
        Ok((found.0, found.1))
    }

    /// Who wrote a location last; nobody did if it holds its initial value.
    pub fn written(&self, function: FunctionId, arguments: &[Value]) -> Option<&LastWrite> {
        let machine = &self.session.machine;
        let slot = machine
            .state()
            .slot(machine.program(), function, arguments)?;
        self.present.written.get(&slot)
    }

    /// Undoes the last events, as many as there are; says how many these were.
    pub fn undo(&mut self, count: usize) -> usize {
        let target = self.events.len().saturating_sub(count);
        let undone = self.events.len() - target;
        self.go_to(target);
        undone
    }

    /// Goes through everything that happened once more, and shows each event when it has happened.
    pub fn replay(&mut self, mut show: impl FnMut(&HistoryEvent, &Session)) {
        let events = self.events.clone();
        self.go_to(0);
        for event in events {
            // what failed once fails again, and happened all the same
            let _ = self.happen(event.clone());
            show(&event, &self.session);
        }
    }

    /// The time: as many seconds as steps.
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
        // meanwhile terms were added, and no locations
        let _ = self.session.machine.adopt(program);
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
        let done = self.apply(&event);
        let steps = moment.machine.steps();
        if done.is_err() && self.session.machine.steps() == steps {
            // the machine keeps its state; choices and inputs are drawn once more
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
        let SessionState {
            inputs, choices, ..
        } = &mut self.present;
        match event {
            HistoryEvent::Step => {
                let done = self.session.machine.step(inputs, choices, now_ns + STEP_NS);
                let done = done.map(|_| ()).map_err(|fault| self.report(&fault));
                self.note_updates(true);
                done
            }
            HistoryEvent::Fire(rule) => {
                self.session.fire(rule, inputs, choices, now_ns)?;
                // the rule is forgotten, and with it the places of its parts
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
            // what is computed, or local to a rule, was refused when the text was read
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
