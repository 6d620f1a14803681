//! Monitors: the properties of a specification, watched while one machine runs.
//!
//! A position of a run is a state together with the inputs of the step that follows. A monitor therefore learns about a position in
//! two halves: the state, right after the step that led to it ([`Monitors::after_step`]), and the inputs, when the next step begins
//! ([`Monitors::before_step`]). A violation that the state alone shows is found in the step that causes it, before its effects leave.
//!
//! Conditions are evaluated only if a location that they read has changed, and formulas only if a condition has.
//!
//! ```
//! # use asmotion_lang::{FirstChoice, MemoryFiles, NoInputs};
//! # let mut files = MemoryFiles::new();
//! # files.add("counter.asm", "asm counter
//! # import StandardLibrary
//! # import CTLLibrary
//! # signature:
//! #   controlled n: Integer
//! # definitions:
//! #   CTLSPEC ag(n < 2)
//! #   main rule r_Main = n := n + 1
//! # default init s0:
//! #   function n = 0
//! # ");
//! # let mut specification = asmotion_lang::open("counter.asm", &files).map_err(|it| it.to_string())?;
//! use asmotion_verify::Monitors;
//! let mut monitors = Monitors::of(&mut specification, &[]).map_err(|it| format!("{it:?}"))?;
//! let mut machine = specification.machine().map_err(|fault| format!("{fault:?}"))?;
//! let mut violated_in = Vec::new();
//! for now_ns in 0..3 {
//!     let mut found = monitors.before_step(&mut machine, &mut NoInputs, now_ns, &|_| true);
//!     machine.step(&mut NoInputs, &mut FirstChoice, now_ns).map_err(|fault| format!("{fault:?}"))?;
//!     found.extend(monitors.after_step(&mut machine, now_ns));
//!     monitors.end_step();
//!     violated_in.extend(found.iter().map(|it| (machine.steps(), it.is_new)));
//! }
//! assert_eq!(violated_in, [(2, true), (3, false)]);
//! # Ok::<(), String>(())
//! ```

mod condition;
mod prepare;
mod state;
mod within;

pub use state::MonitorsState;

use crate::property::PropertyKind;
use asmotion_diagnostics::Span;
use asmotion_lang::ir::FunctionId;
use asmotion_lang::{Environment, Machine, NoInputs};
use asmotion_temporal::{Monitor, MonitorState, MonitorVerdict, ResponseMonitor, ResponseState};
use condition::WatchedCondition;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A property from outside of the specification.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GivenProperty {
    /// A term: a formula of CTL or LTL, or a condition of every state.
    pub text: String,
    /// The time within which what it says to happen eventually has to happen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within_ns: Option<i64>,
}

/// A property that is watched.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WatchedProperty {
    /// Kind of the property.
    pub kind: PropertyKind,
    /// Declared name, if it has one.
    pub name: Option<String>,
    /// Text of the formula, on one line.
    pub text: String,
    /// File name and line; empty for a property from outside of the specification.
    pub place: String,
    /// Place of the property; `None` for one from outside.
    pub at: Option<Span>,
    /// The time within which what it says to happen eventually has to happen.
    pub within_ns: Option<i64>,
    /// Reasons for which parts of the formula are not watched; empty if all of it is.
    pub unwatched: Vec<String>,
}

/// A property that is not watched, because a run cannot show that it is violated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnwatchedProperty {
    /// Kind of the property.
    pub kind: PropertyKind,
    /// Text of the formula, on one line.
    pub text: String,
    /// File name and line.
    pub place: String,
    /// Place of the property; `None` for one from outside.
    pub at: Option<Span>,
    /// Reason that a run cannot watch it.
    pub reason: String,
}

/// A violation of a property in a step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PropertyViolation {
    /// Index in [`Monitors::watched`].
    pub property: usize,
    /// The deadline of a response has passed.
    pub is_late: bool,
    /// The property was not violated in the step before.
    pub is_new: bool,
    /// The conditions of the formula.
    pub conditions: Vec<ConditionValue>,
}

/// The values of a condition at a violation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConditionValue {
    /// Text of the condition.
    pub text: String,
    /// Its value before the step, with the inputs of the step.
    pub before: Option<bool>,
    /// Its value after the step; `None` if it depends on the inputs of the next one, or if the step did not take place.
    pub after: Option<bool>,
}

/// The monitors of a specification.
#[derive(Clone, Debug, Default)]
pub struct Monitors {
    /// Shared by the monitors of all machines of a specification, as are `unwatched`.
    watched: Arc<Vec<WatchedProperty>>,
    unwatched: Arc<Vec<UnwatchedProperty>>,
    conditions: Vec<WatchedCondition>,
    watches: Vec<PropertyWatch>,
    /// Number of changes of conditions so far.
    changes: u64,
}

/// The monitor of a property, with what it knows about the run.
#[derive(Clone, Debug)]
struct PropertyWatch {
    safety: Option<(Arc<Monitor>, MonitorState)>,
    response: Option<ResponseWatch>,
    /// Indices of its conditions.
    conditions: Arc<[usize]>,
    /// As long as no condition changes, the next position changes nothing and violates nothing.
    is_stable: bool,
    /// The number of changes of conditions at the last position.
    seen: u64,
    /// It was violated in the last step.
    was_violated: bool,
    /// It has been violated in this step.
    is_violated: bool,
    /// The state of the current position alone shows a violation, which has been returned.
    is_found: bool,
    /// Number of steps in which it was violated.
    violated_steps: u64,
}

#[derive(Clone, Debug)]
struct ResponseWatch {
    monitor: Arc<ResponseMonitor>,
    state: ResponseState,
    /// The state after the step that has just been made, until it is known that the step counts.
    after_step: Option<ResponseState>,
    within_ns: i64,
}

impl Monitors {
    /// The watched properties.
    pub fn watched(&self) -> &[WatchedProperty] {
        &self.watched
    }

    /// The properties that no run can show to be violated.
    pub fn unwatched(&self) -> &[UnwatchedProperty] {
        &self.unwatched
    }

    /// Returns the number of steps in which a property was violated.
    pub fn violated_steps(&self, property: usize) -> u64 {
        let watch = self.watches.get(property);
        watch.map_or(0, |watch| watch.violated_steps)
    }

    /// Returns the time at which the first open response is late.
    pub fn deadline_ns(&self) -> Option<i64> {
        let responses = self.watches.iter().filter_map(|it| it.response.as_ref());
        let deadlines = responses.filter_map(|response| {
            let state = response.after_step.as_ref().unwrap_or(&response.state);
            Some(state.earliest()?.saturating_add(response.within_ns))
        });
        deadlines.min()
    }

    /// Begins again, with a machine in its initial state.
    pub fn begin(&mut self) {
        self.forget_values();
        for watch in &mut self.watches {
            if let Some((monitor, state)) = &mut watch.safety {
                *state = monitor.begin();
            }
            if let Some(response) = &mut watch.response {
                response.state = response.monitor.begin();
                response.after_step = None;
            }
            (watch.is_stable, watch.is_found) = (false, false);
            (watch.was_violated, watch.is_violated) = (false, false);
        }
    }

    /// Forgets the values of conditions, because the machine has changed otherwise than by a step.
    pub fn forget_values(&mut self) {
        for condition in &mut self.conditions {
            condition.is_stale = true;
        }
    }

    /// Learns the inputs of the next step. `is_changed` returns `false` for a monitored function whose locations have the same values
    /// as in the last step. Returns the properties that these inputs violate.
    pub fn before_step(
        &mut self,
        machine: &mut Machine,
        environment: &mut dyn Environment,
        now_ns: i64,
        is_changed: &dyn Fn(FunctionId) -> bool,
    ) -> Vec<PropertyViolation> {
        for condition in &mut self.conditions {
            if condition.is_due(is_changed) {
                let value = condition.evaluate(machine, environment, now_ns);
                self.changes += condition.assign(value, self.changes);
            }
            condition.before = condition.value;
        }
        let mut found = Vec::new();
        for (index, watch) in self.watches.iter_mut().enumerate() {
            let letter = |atom: usize| self.conditions.get(atom).and_then(|it| it.value);
            let is_changed = watch.is_changed(&self.conditions);
            watch.seen = self.changes;
            let is_late = watch.pass_response(now_ns, &letter);
            let is_violated = is_changed && watch.pass_safety(&letter);
            let is_violated = !std::mem::take(&mut watch.is_found) && is_violated;
            if is_violated || is_late {
                found.push(watch.violation(index, is_late, &self.conditions, false));
            }
        }
        found
    }

    /// Learns the state after a step that the machine has just made, whose effects are not yet visible outside. Returns the
    /// properties that this state violates, whatever the next inputs are.
    pub fn after_step(&mut self, machine: &mut Machine, now_ns: i64) -> Vec<PropertyViolation> {
        self.mark_stale(machine);
        for condition in &mut self.conditions {
            let is_due = condition.is_stale || condition.is_volatile;
            if is_due && !condition.reads_inputs {
                let value = condition.evaluate(machine, &mut NoInputs, now_ns);
                self.changes += condition.assign(value, self.changes);
            }
        }
        let mut found = Vec::new();
        for (index, watch) in self.watches.iter_mut().enumerate() {
            let letter = |atom: usize| {
                let condition = self.conditions.get(atom)?;
                condition.value.filter(|_| !condition.reads_inputs)
            };
            let is_late = watch.note_response(now_ns, &letter);
            let is_violated = watch.is_changed(&self.conditions) && watch.judges_violated(&letter);
            watch.is_found = is_violated;
            if is_violated || is_late {
                found.push(watch.violation(index, is_late, &self.conditions, true));
            }
        }
        found
    }

    /// Forgets the step that the machine has just made, and that is about to be reverted.
    pub fn undo_step(&mut self, machine: &Machine) {
        self.mark_stale(machine);
        for watch in &mut self.watches {
            watch.is_found = false;
            if let Some(response) = &mut watch.response {
                response.after_step = None;
            }
        }
    }

    /// Ends a step: violations in the next one are new unless there were some in this one.
    pub fn end_step(&mut self) {
        for watch in &mut self.watches {
            watch.violated_steps += u64::from(watch.is_violated);
            watch.was_violated = std::mem::take(&mut watch.is_violated);
        }
    }

    /// Marks the conditions that depend on what the last step changed.
    fn mark_stale(&mut self, machine: &Machine) {
        let step = machine.last_step();
        if !step.extended().is_empty() {
            return self.forget_values();
        }
        let (state, program) = (machine.state(), machine.program());
        for (update, before) in step.updates().iter().zip(step.before()) {
            if update.value == *before {
                continue;
            }
            let Some(function) = state.function(program, update.slot) else {
                continue;
            };
            for condition in &mut self.conditions {
                condition.is_stale |= condition.functions.contains(&function);
            }
        }
    }
}

impl PropertyWatch {
    fn is_changed(&self, conditions: &[WatchedCondition]) -> bool {
        let mut read = self.conditions.iter().filter_map(|it| conditions.get(*it));
        !self.is_stable || read.any(|condition| condition.changed_at > self.seen)
    }

    /// Returns `true` if the current position violates the safety part.
    fn pass_safety(&mut self, letter: &dyn Fn(usize) -> Option<bool>) -> bool {
        let Some((monitor, state)) = &mut self.safety else {
            self.is_stable = true;
            return false;
        };
        let before = state.clone();
        let is_violated = monitor.pass(state, letter) == MonitorVerdict::Violated;
        self.is_stable = before == *state && !is_violated;
        is_violated
    }

    fn judges_violated(&self, letter: &dyn Fn(usize) -> Option<bool>) -> bool {
        self.safety.as_ref().is_some_and(|(monitor, state)| {
            monitor.judge(state, letter) == MonitorVerdict::Violated
        })
    }

    /// Returns `true` if a response is late at the current position, whose inputs are known.
    fn pass_response(&mut self, now_ns: i64, letter: &dyn Fn(usize) -> Option<bool>) -> bool {
        let Some(response) = &mut self.response else {
            return false;
        };
        if let Some(state) = response.after_step.take() {
            response.state = state;
        }
        let (monitor, state) = (&response.monitor, &mut response.state);
        let is_late = monitor.note(state, now_ns, response.within_ns, letter);
        monitor.pass(state, letter);
        is_late
    }

    /// Returns `true` if a response is late after a step.
    fn note_response(&mut self, now_ns: i64, letter: &dyn Fn(usize) -> Option<bool>) -> bool {
        let Some(response) = &mut self.response else {
            return false;
        };
        let mut state = response.state.clone();
        let is_late = response
            .monitor
            .note(&mut state, now_ns, response.within_ns, letter);
        response.after_step = Some(state);
        is_late
    }

    fn violation(
        &mut self,
        property: usize,
        is_late: bool,
        conditions: &[WatchedCondition],
        is_after: bool,
    ) -> PropertyViolation {
        let is_new = !self.was_violated && !self.is_violated;
        self.is_violated = true;
        let conditions = self.conditions.iter().filter_map(|it| conditions.get(*it));
        let conditions = conditions.map(|condition| ConditionValue {
            text: condition.text.to_string(),
            before: condition.before,
            after: condition
                .value
                .filter(|_| is_after && !condition.reads_inputs),
        });
        PropertyViolation {
            property,
            is_late,
            is_new,
            conditions: conditions.collect(),
        }
    }
}
