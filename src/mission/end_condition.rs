//! End conditions of a mission.

use super::error::MissionError;
use super::outcome::MissionOutcome;
use crate::files::DiskLoader;
use asmotion_component::{State, Time};
use asmotion_coordinator::{
    BRIEF_STEP_REPORT, CONTROL_STATES, STEP_REPORT, StepRecord, function_of,
};
use asmotion_datum::Datum;
use asmotion_lang::machine::Machine;
use asmotion_lang::simulate::AwaitedUpdate;
use asmotion_plan::{Component, Implementation, Part, Plan};
use asmotion_runtime::{Event, Observer, Run};
use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

/// Interval, in the run's own time, at which the end conditions are tested.
pub(super) const SLICE: Duration = Duration::from_millis(100);

/// Returns the end conditions; by default `mode` with its usual value, if a specification has it.
pub(super) fn awaited_updates(
    plan: &Plan,
    requested: Option<&[(String, String)]>,
    default: &str,
) -> Result<Vec<AwaitedUpdate>, MissionError> {
    let machines = machines(plan);
    let Some(requested) = requested else {
        let usual =
            |(_, machine): &(String, Machine)| AwaitedUpdate::of(machine, "mode", default).ok();
        return Ok(machines.iter().find_map(usual).into_iter().collect());
    };
    let mut all = Vec::new();
    for (location, value) in requested {
        let mut reasons = Vec::new();
        for (path, machine) in &machines {
            match AwaitedUpdate::of(machine, location, value) {
                Ok(awaited) => all.push(awaited),
                Err(reason) => reasons.push((path.clone(), reason)),
            }
        }
        // it suffices if one specification can establish the condition
        if reasons.len() == machines.len() {
            let requested = format!("{location}={value}");
            return Err(MissionError::NeverEnds { requested, reasons });
        }
    }
    Ok(all)
}

/// The specification of a component; `None` if it is implemented otherwise.
fn file(component: &Component) -> Option<&str> {
    match &component.implementation {
        Implementation::Asm { file, .. } => Some(file),
        Implementation::Rust(_)
        | Implementation::Builtin { .. }
        | Implementation::Process { .. }
        | Implementation::Ros { .. }
        | Implementation::Orocos { .. } => None,
    }
}

/// The components of a part that run a specification, with its file.
fn specifications(plan: &Plan, part: &Part) -> BTreeMap<String, String> {
    let here = plan.components.iter().filter(|it| part.has(&it.name));
    here.filter_map(|it| Some((it.name.clone(), file(it)?.to_owned())))
        .collect()
}

/// Machines of the plan's specifications, each once; errors of their initial states are reported at the start.
fn machines(plan: &Plan) -> Vec<(String, Machine)> {
    let mut seen = BTreeSet::new();
    let files = plan.components.iter().filter_map(file);
    let of = |file: &str| {
        let specification = asmotion_lang::open(file, &DiskLoader).ok()?;
        Some((file.to_owned(), specification.machine().ok()?))
    };
    files
        .filter(|file| seen.insert(*file))
        .filter_map(of)
        .collect()
}

/// Watches for the end conditions.
#[derive(Default)]
pub(super) struct EndCondition {
    until: Vec<AwaitedUpdate>,
    unless: Vec<AwaitedUpdate>,
    /// The components that run a specification here, with its file.
    specifications: BTreeMap<String, String>,
    /// Components whose specifications have met a success condition.
    reached: BTreeSet<String>,
    /// Components whose specifications have met a failure condition, and no success condition since.
    failed: BTreeSet<String>,
    /// Components whose failure does not end the run.
    tolerated: BTreeSet<String>,
    /// Components that have been running.
    started: BTreeSet<String>,
    /// Components that have failed, with the time of their last fault.
    faulted: BTreeMap<String, Time>,
    /// Outcome of the run, once it is known.
    outcome: Option<MissionOutcome>,
}

impl EndCondition {
    pub(super) fn new(
        plan: &Plan,
        part: &Part,
        until: Vec<AwaitedUpdate>,
        unless: Vec<AwaitedUpdate>,
    ) -> Self {
        Self {
            until,
            unless,
            specifications: specifications(plan, part),
            ..Self::default()
        }
    }

    /// Watches the components of another version from now on.
    pub(super) fn follow(&mut self, plan: &Plan, part: &Part) {
        self.specifications = specifications(plan, part);
    }

    /// Continues the run if one of these components fails.
    pub(super) fn tolerating(mut self, components: &[String]) -> Self {
        self.tolerated = components.iter().cloned().collect();
        self
    }

    /// Returns whether a step can meet a condition that does not change a control state.
    pub(super) fn needs_all_steps(&self) -> bool {
        let mut all = self.until.iter().chain(&self.unless);
        all.any(|it| !CONTROL_STATES.contains(&function_of(&it.location)))
    }

    /// Returns whether the run can end after a step: because of its updates, or because a component has failed before and is not
    /// restarted.
    pub(super) fn depends_on_steps(&self) -> bool {
        !self.until.is_empty() || !self.unless.is_empty() || !self.faulted.is_empty()
    }

    /// Returns whether the run can succeed before its time is up.
    pub(super) fn has_goal(&self) -> bool {
        !self.until.is_empty()
    }

    /// Records that a component has met a success or a failure condition. Returns the outcome once all components with its
    /// specification have met one: of several robots, each has to reach its goal, or to give up.
    fn has_ended(&mut self, component: &str, outcome: MissionOutcome) -> Option<MissionOutcome> {
        let (into, other) = if outcome == MissionOutcome::Reached {
            (&mut self.reached, &mut self.failed)
        } else {
            (&mut self.failed, &mut self.reached)
        };
        into.insert(component.to_owned());
        other.remove(component);
        let file = self.specifications.get(component);
        let same = self.specifications.iter();
        let mut same = same
            .filter(|(_, it)| Some(*it) == file)
            .map(|(component, _)| component);
        let has_failed = same.clone().any(|it| self.failed.contains(it));
        let have_ended = same.all(|it| self.reached.contains(it) || self.failed.contains(it));
        let outcome = if has_failed {
            MissionOutcome::Failed
        } else {
            MissionOutcome::Reached
        };
        have_ended.then_some(outcome)
    }

    /// Returns the outcome, once it is known.
    ///
    /// A component that has failed is isolated, and restarted if its `on_exception` says so. The run ends if nothing can be
    /// reached without it: it runs a specification, it could not be started, or its failure has stopped all components.
    pub(super) fn outcome(&self, run: &dyn Run) -> Option<MissionOutcome> {
        let ends = |component: &String| {
            self.specifications.contains_key(component) || !self.started.contains(component)
        };
        let is_fatal = || {
            let mut dead = self.dead(run).peekable();
            dead.peek().is_some()
                && (dead.any(ends) || !self.started.iter().any(|it| run.is_running(it)))
        };
        self.outcome
            .or_else(|| is_fatal().then_some(MissionOutcome::Fault))
    }

    /// Iterates over the components that have failed, are not restarted, and may not fail.
    pub(super) fn dead<'a>(&'a self, run: &'a dyn Run) -> impl Iterator<Item = &'a String> {
        let faulted = self.faulted.iter().filter(move |(component, at)| {
            let state = run.state(component);
            let failed = matches!(state, Some(State::Exception | State::FatalError));
            // a restart passes the exception state at once, and takes its time to configure
            let restarts = run.now() < **at + SLICE;
            !self.tolerated.contains(*component)
                && !state.is_some_and(State::is_running)
                && (!self.started.contains(*component) || failed && !restarts)
        });
        faulted.map(|(component, _)| component)
    }
}

/// Returns whether an event can contribute to an end condition.
pub(super) fn concerns(event: &Event<'_>) -> bool {
    match event {
        Event::Report { kind, data, .. } => match *kind {
            STEP_REPORT => true,
            // a number says that no control state has changed
            BRIEF_STEP_REPORT => !matches!(data, Datum::Int(_)),
            _ => false,
        },
        Event::LifeCycle { .. } | Event::Fault { .. } => true,
        Event::Cycle { .. }
        | Event::Published { .. }
        | Event::Injected { .. }
        | Event::Called { .. }
        | Event::Answered { .. }
        | Event::Replied { .. }
        | Event::Overrun { .. }
        | Event::Late { .. }
        | Event::Denied { .. }
        | Event::Dropped { .. }
        | Event::Property { .. }
        | Event::Lost { .. } => false,
    }
}

impl Observer for EndCondition {
    fn observe(&mut self, at: Time, event: &Event<'_>) {
        if self.outcome.is_some() {
            return;
        }
        match event {
            Event::Fault { component, .. } => {
                self.faulted.insert((*component).to_owned(), at);
            }
            Event::LifeCycle {
                component,
                to: State::Running,
                ..
            } => {
                self.started.insert((*component).to_owned());
            }
            Event::Report {
                component,
                kind,
                data: what,
            } if [STEP_REPORT, BRIEF_STEP_REPORT].contains(kind) => {
                if self.until.is_empty() && self.unless.is_empty() {
                    return;
                }
                // a brief report that is a number says that no control state has changed
                let Some(step) = StepRecord::of_report(what) else {
                    return;
                };
                let has = |ends: &[AwaitedUpdate]| {
                    step.updates.iter().any(|update| {
                        ends.iter()
                            .any(|end| end.location == update.location && end.value == update.after)
                    })
                };
                let met = if has(&self.until) {
                    Some(MissionOutcome::Reached)
                } else {
                    has(&self.unless).then_some(MissionOutcome::Failed)
                };
                self.outcome = met.and_then(|met| self.has_ended(component, met));
            }
            Event::Cycle { .. }
            | Event::Published { .. }
            | Event::Injected { .. }
            | Event::Called { .. }
            | Event::Answered { .. }
            | Event::Replied { .. }
            | Event::LifeCycle { .. }
            | Event::Overrun { .. }
            | Event::Late { .. }
            | Event::Denied { .. }
            | Event::Dropped { .. }
            | Event::Property { .. }
            | Event::Report { .. }
            | Event::Lost { .. } => {}
        }
    }
}
