//! Explains why the time of a run was up: the state of each coordinator, and what it waits for.

use std::collections::BTreeMap;
use std::fmt;

use asmotion_coordinator::{CoordinatorStatus, LocationName, Source};
use asmotion_lang::Specification;
use asmotion_lang::value::{Atom, Value};
use asmotion_plan::{Component, Implementation, Plan, Topic};
use asmotion_runtime::Run;

use crate::files::DiskLoader;

/// A coordinator that had not ended when the time of the run was up.
#[derive(Clone, Debug, PartialEq)]
pub struct StalledCoordinator {
    /// Name of the component.
    pub component: String,
    /// Control state of the component, as in `mode = PLANNING`; `None` if it has none.
    pub state: Option<String>,
    /// Time of its last update in seconds of the run; `None` before the first.
    pub since_s: Option<f64>,
    /// Reasons for which it makes no progress, the most specific first.
    pub reasons: Vec<String>,
}

/// The coordinator and what it waits for, on one line.
impl fmt::Display for StalledCoordinator {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(&self.component)?;
        if let Some(state) = &self.state {
            write!(to, " in {state}")?;
        }
        match self.since_s {
            Some(since) => write!(to, " since {since:.1} s")?,
            None => to.write_str(" since the start")?,
        }
        write!(to, ": {}", self.reasons.join("; "))
    }
}

/// Coordinators of a plan with their status at the end of a run. Those in a long cycle are left out.
pub(super) struct FinalStatuses<'p> {
    plan: &'p Plan,
    statuses: Vec<(&'p Component, CoordinatorStatus)>,
}

impl<'p> FinalStatuses<'p> {
    /// Asks the coordinators whose names are wanted.
    pub(super) fn of(plan: &'p Plan, run: &mut dyn Run, is_wanted: impl Fn(&str) -> bool) -> Self {
        let coordinators = plan.components.iter();
        let coordinators = coordinators.filter(|it| {
            matches!(it.implementation, Implementation::Asm { .. }) && is_wanted(&it.name)
        });
        let status = |component: &'p Component| {
            let entries = run.inspect(&component.name).ok()?;
            Some((component, CoordinatorStatus::of(&entries)?))
        };
        Self {
            plan,
            statuses: coordinators.filter_map(status).collect(),
        }
    }

    /// The names of the coordinators with their control states.
    pub(super) fn control_states(&self) -> impl Iterator<Item = (&str, String)> {
        let all = self.statuses.iter();
        all.filter_map(|(component, status)| Some((&*component.name, status.control_states()?)))
    }

    /// Describes what the coordinators wait for.
    pub(super) fn stalled(&self) -> Vec<StalledCoordinator> {
        self.stalled_among(|_| true)
    }

    /// Describes what those coordinators wait for that have never made an update.
    pub(super) fn stalled_since_start(&self) -> Vec<StalledCoordinator> {
        self.stalled_among(|status| status.last_update.is_none())
    }

    fn stalled_among(&self, is_wanted: fn(&CoordinatorStatus) -> bool) -> Vec<StalledCoordinator> {
        let mut specifications = SpecificationsRead::default();
        let topics = SubscribedTopics::of(self.plan);
        let wanted = self.statuses.iter().filter(|(_, it)| is_wanted(it));
        let describe = |(component, status): &(&Component, CoordinatorStatus)| {
            let Implementation::Asm { file, .. } = &component.implementation else {
                return None;
            };
            Some(StalledCoordinator {
                component: component.name.clone(),
                state: status
                    .control_state()
                    .map(equation)
                    .or_else(|| status.control_states()),
                since_s: status.last_update.as_ref().map(|last| last.at_s),
                reasons: reasons(&topics, component, specifications.get(file), status),
            })
        };
        wanted.filter_map(describe).collect()
    }
}

/// Specifications by file, each read once for all coordinators that run it; `None` if it cannot be read any more.
#[derive(Default)]
struct SpecificationsRead(BTreeMap<String, Option<ControlStates>>);

impl SpecificationsRead {
    fn get(&mut self, file: &str) -> Option<&mut ControlStates> {
        // the file was read at the start of the run
        let read = || {
            let specification = asmotion_lang::open(file, &DiskLoader).ok()?;
            let exits = BTreeMap::new();
            Some(ControlStates {
                specification,
                exits,
            })
        };
        self.0.entry(file.to_owned()).or_insert_with(read).as_mut()
    }
}

/// The control states of a specification, as far as coordinators are in them.
struct ControlStates {
    specification: Specification,
    /// For each control state, as location and value: whether a rule leaves it. `None` if the specification has no such location without
    /// parameters, or no such value.
    exits: BTreeMap<(String, String), Option<bool>>,
}

impl ControlStates {
    /// The control state, if no rule leaves it.
    fn without_exit(&mut self, status: &CoordinatorStatus) -> Option<String> {
        let (location, value) = status.control_state()?;
        let state = (location.to_owned(), value.to_owned());
        let known = || has_exit(&self.specification, location, value);
        let has_exit = (*self.exits.entry(state).or_insert_with(known))?;
        (!has_exit).then(|| format!("no rule leaves `{location} = {value}`"))
    }
}

/// The topics of a plan by component and input.
struct SubscribedTopics<'p>(BTreeMap<(&'p str, &'p str), &'p Topic>);

impl<'p> SubscribedTopics<'p> {
    fn of(plan: &'p Plan) -> Self {
        let ends = plan.topics.iter().flat_map(|topic| {
            let ends = topic.subscribers.iter();
            ends.map(move |end| ((&*end.component, &*end.name), topic))
        });
        // of several topics for an input, the first one counts
        Self(ends.rev().collect())
    }

    fn origin_of(&self, component: &Component, port: &str) -> String {
        match self.0.get(&(&*component.name, port)) {
            Some(topic) if topic.publishers.is_empty() => {
                format!("topic `{}`, which no component publishes", topic.name)
            }
            Some(topic) => format!("topic `{}`", topic.name),
            None => format!("port `{port}`"),
        }
    }
}

fn equation((location, value): (&str, &str)) -> String {
    format!("{location} = {value}")
}

fn reasons(
    topics: &SubscribedTopics<'_>,
    component: &Component,
    control_states: Option<&mut ControlStates>,
    status: &CoordinatorStatus,
) -> Vec<String> {
    if status.step == 0 {
        return vec!["it has made no step".to_owned()];
    }
    let calls = status.calls.iter();
    let mut reasons: Vec<String> = calls
        .map(|call| format!("the call of `{call}` has no reply"))
        .collect();
    reasons.extend(control_states.and_then(|it| it.without_exit(status)));
    let silent = status.silent.iter();
    let read = silent.filter(|function| status.read.contains_key(*function));
    reasons.extend(read.map(|function| no_message(topics, component, function)));
    if reasons.is_empty() {
        reasons.push(last_step(status));
    }
    reasons
}

fn has_exit(specification: &Specification, function: &str, literal: &str) -> Option<bool> {
    let model = &specification.model;
    let mut functions = model.own_functions();
    let (function, _) =
        functions.find(|(_, it)| &*it.name == function && it.parameters.is_empty())?;
    let atom = model.atoms.iter().position(|atom| &*atom.name == literal)?;
    let state = Value::Atom(Atom(u32::try_from(atom).ok()?));
    Some(model.has_exit(function, &state))
}

/// The reason that no message has arrived for a monitored location, with the origin of its messages.
fn no_message(topics: &SubscribedTopics<'_>, component: &Component, location: &str) -> String {
    let name = LocationName::from(location);
    let bound = component.binding.iter().flat_map(|it| &it.monitored);
    let mut bound = bound.filter(|it| {
        let is_selected = !it.key.is_empty() && it.location.function == name.function;
        it.location == name || is_selected
    });
    let origin = match bound.next().map(|monitored| &monitored.from) {
        Some(Source::Port(port)) => topics.origin_of(component, port),
        Some(Source::Request(operation)) => format!("requests of `{operation}`"),
        Some(Source::Timer { .. } | Source::Losses(_) | Source::Value(_)) | None => {
            "its binding".to_owned()
        }
    };
    format!("no message has arrived for `{location}` ({origin})")
}

/// The inputs of the last step, and whether it wrote anything.
fn last_step(status: &CoordinatorStatus) -> String {
    let inputs = status.read.iter();
    let inputs: Vec<String> = inputs
        .map(|(location, value)| format!("{location} = {value}"))
        .collect();
    let inputs = match inputs.as_slice() {
        [] => "no input".to_owned(),
        inputs => inputs.join(", "),
    };
    let is_last = |last: &asmotion_coordinator::LastUpdate| last.step == status.step;
    let wrote = match status.last_update.as_ref().filter(|last| is_last(last)) {
        Some(_) => "still wrote",
        None => "wrote nothing",
    };
    format!("its last step read {inputs} and {wrote}")
}
