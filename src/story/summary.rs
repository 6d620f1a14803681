//! What is left of a mission in the end.

use std::fmt;

use asmotion_component::Time;
use asmotion_coordinator::{StepRecord, UpdateRecord};
use asmotion_datum::Sample;

use super::{DrivenPath, StoryEntry};

/// The functions that hold a control state, by custom.
const CONTROL_STATES: &[&str] = &["mode", "ctl_state", "ctlState", "state"];

/// What is left of a mission in the end.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Steps that wrote something.
    pub steps: u64,
    /// Changes of the control state.
    pub transitions: u64,
    /// Events that the specifications heard.
    pub heard: EventCounts,
    /// Service calls begun.
    pub calls: EventCounts,
    /// Calls that failed or came too late.
    pub failed_calls: u64,
    /// The way of what moves, if anything does.
    pub way: Option<DrivenPath>,
    /// The control state.
    pub control_state: Option<String>,
    /// Faults of components, as "component: fault".
    pub faults: Vec<String>,
    /// The last time anything was seen at.
    pub ended: Option<Time>,
}

/// How often what happened, by name and in the order in which it first did.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct EventCounts(pub Vec<(String, u64)>);

impl EventCounts {
    /// It happened once more.
    pub(super) fn count(&mut self, name: &str) {
        match self.0.iter_mut().find(|(known, _)| known == name) {
            Some((_, count)) => *count += 1,
            None => self.0.push((name.to_owned(), 1)),
        }
    }

    /// How often it happened.
    pub fn of(&self, name: &str) -> u64 {
        let mut all = self.0.iter();
        all.find(|(known, _)| known == name)
            .map_or(0, |(_, count)| *count)
    }
}

impl fmt::Display for EventCounts {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all = self
            .0
            .iter()
            .map(|(name, count)| format!("{name} ×{count}"));
        to.write_str(&all.collect::<Vec<_>>().join(", "))
    }
}

impl Summary {
    /// A step was made.
    pub(super) fn step(&mut self, record: &StepRecord) {
        self.steps += 1;
        if let Some(control) = control(record) {
            self.transitions += 1;
            self.control_state = Some(control.after.clone());
        }
    }

    /// A message, which may say where something is.
    pub(super) fn moved(&mut self, at: Time, sample: &dyn Sample) -> Option<StoryEntry> {
        let place = DrivenPath::place(sample)?;
        self.way.get_or_insert_default().moved(at, place)
    }

    /// An event that a specification heard, which may say where something shall be.
    pub(super) fn wanted(&mut self, sample: &dyn Sample) {
        if let Some(goal) = DrivenPath::goal(sample) {
            self.way.get_or_insert_default().goal = Some(goal);
        }
    }
}

/// The update that changes the control state.
pub(super) fn control(record: &StepRecord) -> Option<&UpdateRecord> {
    let mut updates = record.updates.iter();
    let control = updates.find(|update| CONTROL_STATES.contains(&&*update.location));
    control.filter(|control| control.before != control.after)
}
