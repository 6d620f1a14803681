//! What is known of the state of a specification: the values that its steps have read and written.

use std::collections::{BTreeMap, BTreeSet};

use asmotion_component::Time;
use asmotion_coordinator::StepRecord;
use serde::Serialize;

/// The locations of a specification as of its last reported step, and how often each update was made.
#[derive(Clone, Default, Serialize)]
pub(crate) struct SpecificationState {
    locations: BTreeMap<String, LocationValue>,
    /// Number of updates by the place of the rule, as in `navigate.asm:42`.
    heat: BTreeMap<String, u64>,
    /// Number of the last reported step.
    step: u64,
    /// Number of reported steps.
    reported: u64,
    /// Time of the last reported step.
    #[serde(skip)]
    at: Time,
    /// The functions of the specification; `None` until its text has been replaced.
    #[serde(skip)]
    functions: Option<BTreeSet<String>>,
}

/// The last known value of a location.
#[derive(Clone, Serialize)]
struct LocationValue {
    value: String,
    /// Whether the environment determines it.
    monitored: bool,
    /// Number of the step that read or wrote it; 0 for the initial state.
    step: u64,
    /// Time of this step in seconds of the run.
    t: f64,
}

fn initial_values(locations: &[(String, String)]) -> BTreeMap<String, LocationValue> {
    let locations = locations.iter().map(|(location, value)| {
        let value = LocationValue {
            value: value.clone(),
            monitored: false,
            step: 0,
            t: 0.0,
        };
        (location.clone(), value)
    });
    locations.collect()
}

/// The function of a location such as `f(1)`.
fn function_of(location: &str) -> &str {
    location.split('(').next().unwrap_or(location)
}

impl SpecificationState {
    /// The initial state, as pairs of location and value.
    pub(crate) fn initial(locations: &[(String, String)]) -> Self {
        Self {
            locations: initial_values(locations),
            ..Self::default()
        }
    }

    /// The known locations with their values.
    pub(crate) fn values(&self) -> impl ExactSizeIterator<Item = (&str, &str)> {
        let locations = self.locations.iter();
        locations.map(|(location, value)| (&**location, &*value.value))
    }

    /// Number of the last reported step; 0 before the first one.
    pub(crate) fn number(&self) -> u64 {
        self.step
    }

    /// Number of reported steps.
    pub(crate) fn reported(&self) -> u64 {
        self.reported
    }

    /// Time of the last reported step.
    pub(crate) fn at(&self) -> Time {
        self.at
    }

    /// Begins again in another state. What was counted stays.
    #[cfg(feature = "recording")]
    pub(crate) fn begin_again(&mut self, locations: &[(String, String)]) {
        self.locations = initial_values(locations);
    }

    /// Continues as another machine, which has taken over the state: a location keeps the step that wrote it if its value is the
    /// same, and inputs are kept until they are read again.
    #[cfg(feature = "recording")]
    pub(crate) fn continue_with(&mut self, locations: &[(String, String)]) {
        let mut next = initial_values(locations);
        for (location, value) in std::mem::take(&mut self.locations) {
            match next.get_mut(&location) {
                Some(known) if known.value == value.value => *known = value,
                None if value.monitored => {
                    next.insert(location, value);
                }
                Some(_) | None => {}
            }
        }
        self.locations = next;
    }

    /// Counts updates anew: their places are those of another text from now on.
    pub(crate) fn forget_places(&mut self) {
        self.heat.clear();
    }

    /// Follows the replacement of a running specification by another text with this initial state and these functions. Locations of
    /// functions that the new text has, too, keep their values.
    pub(crate) fn replace_text(
        &mut self,
        initial: &[(String, String)],
        functions: &BTreeSet<String>,
    ) {
        let known = std::mem::replace(&mut self.locations, initial_values(initial));
        let kept = known.into_iter();
        let kept = kept.filter(|(location, _)| functions.contains(function_of(location)));
        self.locations.extend(kept);
        self.forget_places();
        self.functions = Some(functions.clone());
    }

    /// Returns `false` for a step of the replaced text, which can be reported after the replacement. Detects it only by updates of
    /// functions that the new text lacks.
    fn is_of_this_text(&self, record: &StepRecord) -> bool {
        let Some(functions) = &self.functions else {
            return true;
        };
        let mut updates = record.updates.iter();
        updates.all(|update| functions.contains(function_of(&update.location)))
    }

    /// Takes a step. Returns whether it may be one of the present text; another one changes nothing.
    pub(crate) fn step(&mut self, at: Time, record: &StepRecord) -> bool {
        if !self.is_of_this_text(record) {
            return false;
        }
        self.step = record.number;
        self.at = at;
        self.reported += 1;
        let (step, t) = (record.number, at.seconds());
        let mut set = |location: &String, value: &String, monitored| {
            let value = LocationValue {
                value: value.clone(),
                monitored,
                step,
                t,
            };
            self.locations.insert(location.clone(), value);
        };
        for (location, value) in &record.inputs {
            set(location, value, true);
        }
        for update in &record.updates {
            set(&update.location, &update.after, false);
        }
        for update in &record.updates {
            *self.heat.entry(update.place.clone()).or_default() += 1;
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asmotion_coordinator::UpdateRecord;

    fn step(number: u64, updates: &[(&str, &str)]) -> StepRecord {
        let updates = updates.iter().map(|(location, after)| UpdateRecord {
            location: (*location).to_owned(),
            before: String::new(),
            after: (*after).to_owned(),
            place: format!("n.asm:{number}"),
        });
        StepRecord {
            number,
            updates: updates.collect(),
            ..StepRecord::default()
        }
    }

    #[test]
    fn a_late_step_of_the_text_before_changes_nothing() {
        let mut state = SpecificationState::initial(&[("n".to_owned(), "0".to_owned())]);
        state.step(
            Time::ZERO,
            &step(1, &[("n", "1"), ("said(1)", "hello"), ("kept", "7")]),
        );
        let functions = ["n", "kept", "twice"].map(str::to_owned).into();
        let initial = ["n", "twice"].map(|it| (it.to_owned(), "0".to_owned()));
        state.replace_text(&initial, &functions);
        assert!(!state.step(Time::ZERO, &step(2, &[("n", "2"), ("said(1)", "hello")])));
        let values: Vec<_> = state.values().collect();
        assert_eq!(values, [("kept", "7"), ("n", "1"), ("twice", "0")]);
        assert_eq!(state.heat.len(), 0);
        state.step(Time::ZERO, &step(3, &[("n", "2"), ("twice", "4")]));
        let values: Vec<_> = state.values().collect();
        assert_eq!(values, [("kept", "7"), ("n", "2"), ("twice", "4")]);
        assert_eq!(state.heat.keys().collect::<Vec<_>>(), ["n.asm:3"]);
    }
}
