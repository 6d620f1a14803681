//! Carries out the actions of a mission.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use asmotion_component::{Fault, State, Time, Transition};
use asmotion_composite::At;
use asmotion_composite::mission::{
    MissionAct, MissionAction, MissionExpectation, MissionFile, MissionRequirement, MissionValue,
};
use asmotion_composite::table::NamedValue;
use asmotion_datum::Datum;
use asmotion_diagnostics::{Finding, Report, Span};
use asmotion_plan::Plan;
use asmotion_runtime::Run;

use super::expectation::{RequirementKind, WatchedExpectation};
use super::monitor::{ActionTrigger, RunMonitor};
use super::parse;
use super::resolve::PlanNames;
use crate::codes::v032::InvalidRunCondition;
use crate::codes::v034::ActionFailed;
use crate::mission::{Director, MissionOutcome};

/// An action, ready to be carried out.
struct PlannedAct {
    act: MissionAct,
    /// Time of the action, for its order; `None` until it is carried out.
    done: Option<Time>,
    at: Span,
}

/// Directs a run by a mission file.
pub(super) struct MissionDirector {
    file: MissionFile,
    monitor: Arc<Mutex<RunMonitor>>,
    acts: Vec<PlannedAct>,
    /// Actions that failed.
    pub report: Report,
}

impl MissionDirector {
    pub(super) fn new(file: MissionFile) -> Self {
        let acts = file.actions.iter().map(|action| PlannedAct {
            act: action.act.clone(),
            done: None,
            at: action.span,
        });
        Self {
            acts: acts.collect(),
            file,
            monitor: Arc::default(),
            report: Report::new(),
        }
    }

    /// The observer of the run.
    pub(super) fn monitor(&self) -> Arc<Mutex<RunMonitor>> {
        self.monitor.clone()
    }

    /// Locations of the actions that have not been carried out.
    pub(super) fn open(&self) -> impl Iterator<Item = (usize, Span)> {
        let acts = self.acts.iter().enumerate();
        acts.filter(|(_, act)| act.done.is_none())
            .map(|(index, act)| (index, act.at))
    }

    /// Carries out an action.
    fn perform(&self, index: usize, run: &mut dyn Run) -> Result<(), String> {
        match &self.acts[index].act {
            MissionAct::Write { to, value } => {
                let sample = Arc::new(value.value.0.datum());
                let now = run.now();
                let written = match to.strip_prefix("topic:") {
                    Some(topic) => run.publish_sample(now, topic, sample),
                    None => run.inject_sample(now, to, sample),
                };
                written.map_err(|error| error.to_string())
            }
            MissionAct::Set {
                component,
                properties,
            } => {
                let values = data(properties);
                let set = run.set_properties(component, &values);
                set.map_err(|error| error.to_string())
            }
            MissionAct::Stop(component) => transition(run, component, Transition::Stop),
            MissionAct::Start(component) => {
                if run.state(component) == Some(State::Exception) {
                    transition(run, component, Transition::ResetException)?;
                }
                if run.state(component) == Some(State::PreOperational) {
                    transition(run, component, Transition::Configure)?;
                }
                transition(run, component, Transition::Start)
            }
            MissionAct::Fail(component) => {
                let fault = Fault::new("failed by the mission");
                let failed = run.inject_fault(component, fault);
                failed.map_err(|error| error.to_string())
            }
        }
    }

    /// Resolves the conditions and names of the file.
    fn resolve(&self, plan: &Plan) -> Result<RunMonitor, Report> {
        let mut builder = MonitorBuilder {
            names: PlanNames::new(plan),
            monitor: RunMonitor::default(),
            report: Report::new(),
        };
        for action in &self.file.actions {
            builder.action(action, plan);
        }
        for expectation in &self.file.expectations {
            builder.expectation(expectation);
        }
        builder.monitor.end = builder.optional(self.file.end.as_ref());
        let named = self.file.components.iter().map(|it| &it.name);
        for component in named.chain(&self.file.may_fail) {
            let known = builder.names.component(component).map(drop);
            builder.note(known);
        }
        let MonitorBuilder {
            names,
            mut monitor,
            report,
        } = builder;
        if report.has_errors() {
            return Err(report.finish());
        }
        (monitor.operands, monitor.values) = (names.operands, names.values);
        Ok(monitor)
    }
}

impl Director for MissionDirector {
    fn prepare(&mut self, plan: &Plan) -> Result<(), Report> {
        let monitor = self.resolve(plan)?;
        *lock(&self.monitor) = monitor;
        Ok(())
    }

    fn has_goal(&self) -> bool {
        self.file.end.is_some()
    }

    fn act(&mut self, run: &mut dyn Run) -> Option<MissionOutcome> {
        if !lock(&self.monitor).started {
            lock(&self.monitor).start();
        }
        loop {
            let now = run.now();
            if lock(&self.monitor).ended.is_some() {
                return Some(MissionOutcome::Reached);
            }
            // an action can trigger another one
            let due = lock(&self.monitor).due.clone();
            let open = due.iter().zip(&self.acts).enumerate();
            let open = open
                .filter(|(_, (due, act))| act.done.is_none() && due.is_some_and(|due| due <= now));
            let next = open.min_by_key(|(index, (due, _))| (**due, *index));
            let (index, _) = next?;
            self.acts[index].done = Some(now);
            if let Err(reason) = self.perform(index, run) {
                let at = self.acts[index].at;
                self.report.push(ActionFailed { reason, at }.diagnostic());
            }
        }
    }

    fn finish(&mut self, now: Time) {
        lock(&self.monitor).finish(now);
    }

    fn next(&self) -> Option<Time> {
        let monitor = lock(&self.monitor);
        let due = monitor.due.iter().zip(&self.acts);
        let open = due.filter(|(_, act)| act.done.is_none());
        open.filter_map(|(due, _)| *due).min()
    }

    fn is_due(&self, now: Time) -> bool {
        lock(&self.monitor).ended.is_some() || self.next().is_some_and(|next| next <= now)
    }
}

/// Makes the observer of a run.
struct MonitorBuilder<'p> {
    names: PlanNames<'p>,
    monitor: RunMonitor,
    report: Report,
}

impl MonitorBuilder<'_> {
    fn note<T>(&mut self, result: Result<T, Box<InvalidRunCondition>>) -> Option<T> {
        result
            .map_err(|error| self.report.push(error.diagnostic()))
            .ok()
    }

    /// Resolves a condition; position 0 stands for one with an error, which is reported.
    fn condition(&mut self, text: &At<String>) -> usize {
        let condition = parse::condition(text, &mut self.names);
        let Some(condition) = self.note(condition) else {
            return 0;
        };
        self.monitor.conditions.push(condition);
        self.monitor.conditions.len() - 1
    }

    fn optional(&mut self, text: Option<&At<String>>) -> Option<usize> {
        text.map(|text| self.condition(text))
    }

    fn action(&mut self, action: &MissionAction, plan: &Plan) {
        let delay = seconds(action.delay_s.as_ref()).unwrap_or_default();
        let trigger = match (&action.when, seconds(action.time_s.as_ref())) {
            (Some(when), _) => ActionTrigger::When(self.condition(when), delay),
            (None, time) => ActionTrigger::At(Time::ZERO + time.unwrap_or_default()),
        };
        self.monitor.triggers.push(trigger);
        match &action.act {
            MissionAct::Write { to, value } => {
                let kind = self.names.written(to);
                let kind = self.note(kind);
                let schema = kind.and_then(|kind| plan.types.get(&kind));
                if let Some(Err(error)) = schema.map(|it| it.accepts(&value.value.0.datum())) {
                    self.report.push(
                        InvalidRunCondition {
                            reason: format!("`{}` does not take this message: {error}", to.value),
                            at: value.span,
                            help: None,
                        }
                        .diagnostic(),
                    );
                }
            }
            MissionAct::Set { component, .. }
            | MissionAct::Stop(component)
            | MissionAct::Start(component)
            | MissionAct::Fail(component) => {
                let known = self.names.component(component).map(drop);
                self.note(known);
            }
        }
    }

    fn expectation(&mut self, expectation: &MissionExpectation) {
        let (kind, condition) = match &expectation.requirement {
            MissionRequirement::Eventually(condition) => (RequirementKind::Eventually, condition),
            MissionRequirement::Always(condition) => (RequirementKind::Always, condition),
            MissionRequirement::Never(condition) => (RequirementKind::Never, condition),
        };
        let condition = self.condition(condition);
        let after = self.optional(expectation.after.as_ref());
        let until = self.optional(expectation.until.as_ref());
        let within = seconds(expectation.within_s.as_ref());
        let watched = WatchedExpectation::new(kind, condition, (after, until), within);
        self.monitor.expectations.push(watched);
    }
}

/// Property values as data.
pub(super) fn data(properties: &[NamedValue<MissionValue>]) -> Vec<(String, Datum)> {
    let properties = properties.iter();
    properties
        .map(|it| (it.name.value.clone(), it.value.0.datum()))
        .collect()
}

fn transition(run: &mut dyn Run, component: &str, transition: Transition) -> Result<(), String> {
    run.transition(component, transition)
        .map_err(|error| error.to_string())
}

/// A time of the file, of whole nanoseconds.
pub(super) fn seconds(time: Option<&At<f64>>) -> Option<Duration> {
    time.map(|time| Duration::from_secs_f64(time.value))
}

/// Locks the mutex; its content is consistent even if a listener panicked while it held the lock.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
