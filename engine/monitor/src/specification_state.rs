//! What is known of the state of a specification: the values that its steps have read and written.

use std::collections::BTreeMap;

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

impl SpecificationState {
    /// The initial state, as pairs of location and value.
    pub(crate) fn initial(locations: &[(String, String)]) -> Self {
        Self {
            locations: initial_values(locations),
            ..Self::default()
        }
    }

    /// Begins again in another state. What was counted stays.
    #[cfg(feature = "recording")]
    pub(crate) fn begin_again(&mut self, locations: &[(String, String)]) {
        self.locations = initial_values(locations);
    }

    /// Takes a step.
    pub(crate) fn step(&mut self, at: Time, record: &StepRecord) {
        self.step = record.number;
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
    }
}
