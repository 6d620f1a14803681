//! The summary of a mission.

use std::collections::BTreeMap;
use std::fmt;

use asmotion_component::Time;
use asmotion_coordinator::{CONTROL_STATES, StepRecord, UpdateRecord, function_of};
use asmotion_datum::Sample;
use asmotion_plan::{MANY_NUMBERED, NumberedName};

use crate::common::common;
use crate::driven_path::DrivenPath;
use crate::entry::StoryEntry;
use crate::robot::Robots;

/// The summary of a mission.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Number of steps with updates.
    pub steps: u64,
    /// Number of changes of the control state.
    pub transitions: u64,
    /// Number of messages received by specifications, by name.
    pub received: EventCounts,
    /// Number of service calls, by operation. A call counts once, whatever number of attempts and bindings it takes.
    pub calls: EventCounts,
    /// Number of calls that failed or timed out.
    pub failed_calls: u64,
    /// The robots that moved.
    pub robots: Robots,
    /// The last control state of each coordinator that has one, by component.
    pub control_states: BTreeMap<String, String>,
    /// Number of collisions reported by a simulated world.
    pub collisions: u64,
    /// Faults of components, as "component: fault".
    pub faults: Vec<String>,
}

/// Largest number of names that are counted apart: names come from outside.
const MOST_NAMES: usize = 256;
/// Name under which the others are counted.
const OTHERS: &str = "others";

/// Counts of events by name, in order of first occurrence; beyond 256 names, the others count as one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct EventCounts(pub Vec<(String, u64)>);

impl EventCounts {
    /// Adds one to the count of a name.
    pub(super) fn count(&mut self, name: &str) {
        let position = |name: &str| self.0.iter().position(|(known, _)| known == name);
        let is_full = self.0.len() >= MOST_NAMES;
        let known = position(name).or_else(|| is_full.then(|| position(OTHERS)).flatten());
        let name = if is_full { OTHERS } else { name };
        match known.and_then(|known| self.0.get_mut(known)) {
            Some((_, count)) => *count += 1,
            None => self.0.push((name.to_owned(), 1)),
        }
    }

    /// The count of a name; 0 if it has not occurred.
    pub fn of(&self, name: &str) -> u64 {
        let mut all = self.0.iter();
        all.find(|(known, _)| known == name)
            .map_or(0, |(_, count)| *count)
    }
}

impl fmt::Display for EventCounts {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all = folded(&self.0).into_iter();
        let all = all.map(|(name, count)| format!("{name} ×{count}"));
        to.write_str(&all.collect::<Vec<_>>().join(", "))
    }
}

/// Counts names that differ only in their first number together: `rover1/goal` to `rover20/goal` as `rover1…20/goal`.
fn folded(counts: &[(String, u64)]) -> Vec<(String, u64)> {
    let numbered = |name| NumberedName::of(name).and_then(|it| Some((it, it.number()?)));
    let mut rows: Vec<(String, u64)> = Vec::new();
    let mut families: BTreeMap<(&str, &str), Vec<(u64, u64)>> = BTreeMap::new();
    for (name, count) in counts {
        if let Some((NumberedName { before, after, .. }, number)) = numbered(name) {
            let family = families.entry((before, after)).or_default();
            family.push((number, *count));
        }
    }
    families.retain(|_, members| members.len() >= MANY_NUMBERED);
    for (name, count) in counts {
        let members = numbered(name).and_then(|(name, _)| {
            let members = families.get(&(name.before, name.after))?;
            Some((name, members))
        });
        let Some((name, members)) = members else {
            rows.push((name.clone(), *count));
            continue;
        };
        let numbers = || members.iter().map(|(number, _)| *number);
        if let (Some(least), Some(most)) = (numbers().min(), numbers().max()) {
            let row = name.of_range((least, most));
            let sum = members.iter().map(|(_, count)| count).sum();
            // in the place of the first of them
            if !rows.iter().any(|(name, _)| *name == row) {
                rows.push((row, sum));
            }
        }
    }
    rows
}

impl Summary {
    /// Adds a step.
    pub(super) fn step(&mut self, component: &str, record: &StepRecord) {
        self.steps += 1;
        self.transitions += changed_control_states(record).count() as u64;
        if let Some(control) = control(record) {
            self.set_control_state(component, &control.after);
            self.robots.set_cause(component, &record.inputs);
        }
    }

    /// The control state in which all coordinators are; `None` if they differ, or if no specification has one.
    pub fn control_state(&self) -> Option<&str> {
        common(self.control_states.values())
    }

    /// Adds the control state of a coordinator at the end; that of its last step takes precedence.
    pub fn add_final_control_state(&mut self, component: &str, state: &str) {
        if !self.control_states.contains_key(component) {
            self.set_control_state(component, state);
        }
    }

    fn set_control_state(&mut self, component: &str, state: &str) {
        self.robots.set_control_state(component, state);
        self.control_states
            .insert(component.to_owned(), state.to_owned());
    }

    /// Forgets the control states of coordinators that are not in a new version of the system.
    pub(super) fn retain_coordinators(&mut self, is_present: impl Fn(&str) -> bool) {
        self.control_states
            .retain(|component, _| is_present(component));
        self.robots.retain_control_states(&is_present);
    }

    /// Handles a message of a component, which may contain a position. Returns a report of progress, if due.
    pub(super) fn moved(
        &mut self,
        component: &str,
        at: Time,
        sample: &dyn Sample,
    ) -> Option<StoryEntry> {
        let position = DrivenPath::position(sample)?;
        let report = self.robots.moved(component, at, position);
        report.map(StoryEntry::single)
    }

    /// Handles a message of an output, which may contain the true position of a simulated robot.
    pub(super) fn observe_truth(&mut self, component: &str, port: &str, sample: &dyn Sample) {
        if let Some(position) = DrivenPath::true_position(port, sample) {
            self.robots.set_true_position(component, position);
        }
    }
}

/// The update that changes the control state of the coordinator itself, if any.
pub(super) fn control(record: &StepRecord) -> Option<&UpdateRecord> {
    let mut changed = changed_control_states(record);
    changed.find(|update| function_of(&update.location) == update.location)
}

/// The updates that change a control state, of the coordinator or of an agent: of a function with a usual name.
fn changed_control_states(record: &StepRecord) -> impl Iterator<Item = &UpdateRecord> {
    let updates = record.updates.iter();
    let control = updates.filter(|update| CONTROL_STATES.contains(&function_of(&update.location)));
    control.filter(|control| control.before != control.after)
}
