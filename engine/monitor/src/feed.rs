//! The feed: what is known of a system, written by its source and read by the tabs.
//!
//! The writer is the thread that passes events on. It never waits for a reader: each output keeps only its newest sample, and
//! steps and log entries are in rings, which a reader follows with a cursor of its own.

use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock};
use std::time::Instant;

use asmotion_component::Time;
use asmotion_coordinator::{STEP_REPORT, StepRecord};
use asmotion_datum::Sample;
use asmotion_remote::Presence;
use asmotion_runtime::{Event, Observer};
use serde_json::json;

use crate::log_entry;
use crate::output_slot::{OutputSlot, OutputSummary};
use crate::ring::Ring;
use crate::specification_state::SpecificationState;

/// Number of steps that are kept.
const STEPS: usize = 1024;
/// Number of steps of each specification that a new tab receives.
const HISTORY: usize = 400;
/// Number of log entries that are kept.
const LOG: usize = 2048;
/// Number of log entries of calls and replies that are kept.
const CALLS: usize = 1024;

/// The newest samples, steps, log entries and figures of a system. Clones refer to the same feed.
#[derive(Clone)]
pub struct Feed(Arc<FeedParts>);

struct FeedParts {
    began: Instant,
    /// By component, then by port: both are found without allocation.
    outputs: RwLock<HashMap<String, HashMap<String, Arc<OutputSlot>>>>,
    state: Mutex<FeedState>,
}

/// The part of a feed that is read and written as a whole, under one lock.
pub(crate) struct FeedState {
    /// Time of the newest event.
    pub time: Time,
    /// Steps as JSON.
    pub steps: Ring<Arc<str>>,
    /// Log entries as JSON, without calls.
    pub log: Ring<Arc<str>>,
    /// Log entries of calls and replies, which can be many: they do not displace the others.
    pub calls: Ring<Arc<str>>,
    /// States of specifications, by component.
    pub specifications: BTreeMap<String, SpecificationState>,
    /// The last steps of each specification as JSON: a busy one does not displace those of the others.
    pub history: BTreeMap<String, Ring<Arc<str>>>,
    /// The newest description of the components; `None` before the first one.
    pub presence: Option<Arc<NewestPresence>>,
    /// Number of events that were not observed.
    pub lost: u64,
    /// How the run has ended; `None` while it is under way.
    pub end: Option<String>,
}

/// A description of the components.
pub(crate) struct NewestPresence {
    /// Number of descriptions so far.
    pub number: u64,
    /// States, rates and properties of the components.
    pub presence: Presence,
    /// The same as JSON.
    pub json: Arc<str>,
}

impl Default for Feed {
    fn default() -> Self {
        Self::new(Vec::new())
    }
}

impl Feed {
    /// Creates a feed. `initial` are the initial states of specifications: components, with pairs of location and value.
    pub(crate) fn new(initial: Vec<(String, Vec<(String, String)>)>) -> Self {
        let initial = initial.iter().map(|(component, locations)| {
            (component.clone(), SpecificationState::initial(locations))
        });
        Self(Arc::new(FeedParts {
            began: Instant::now(),
            outputs: RwLock::default(),
            state: Mutex::new(FeedState {
                time: Time::ZERO,
                steps: Ring::new(STEPS),
                log: Ring::new(LOG),
                calls: Ring::new(CALLS),
                specifications: initial.collect(),
                history: BTreeMap::new(),
                presence: None,
                lost: 0,
                end: None,
            }),
        }))
    }

    /// Takes a description of the components.
    pub fn describe(&self, presence: Presence) {
        let json = asmotion_datum::Datum::of(&presence).map(|it| crate::rendering::json(&it));
        // every description is representable
        let json: Arc<str> = json.unwrap_or_else(|_| "null".to_owned()).into();
        let mut state = self.state();
        let number = state.presence.as_ref().map_or(0, |known| known.number) + 1;
        state.presence = Some(Arc::new(NewestPresence {
            number,
            presence,
            json,
        }));
    }

    /// Ends the feed: the run has ended in this way.
    pub fn end(&self, outcome: &str) {
        self.state().end = Some(outcome.to_owned());
    }

    /// Records a command of a tab.
    pub(crate) fn command(&self, client: &str, text: &str) {
        let mut state = self.state();
        let entry = log_entry::command(state.time, client, text);
        state.log.push(entry);
    }

    /// Locks the state for reading or writing.
    pub(crate) fn state(&self) -> MutexGuard<'_, FeedState> {
        self.0.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Milliseconds since the feed began.
    pub(crate) fn milliseconds(&self, at: Instant) -> f64 {
        at.saturating_duration_since(self.0.began).as_secs_f64() * 1e3
    }

    /// The output `Component.port`; created if it has not written yet.
    pub(crate) fn output(&self, name: &str) -> Option<Arc<OutputSlot>> {
        let (component, port) = name.rsplit_once('.')?;
        let outputs = self
            .0
            .outputs
            .read()
            .unwrap_or_else(PoisonError::into_inner);
        let known = outputs.get(component).and_then(|ports| ports.get(port));
        known.cloned()
    }

    /// All outputs that have written, by name.
    pub(crate) fn outputs(&self) -> Vec<OutputSummary> {
        let now = Instant::now();
        let outputs = self
            .0
            .outputs
            .read()
            .unwrap_or_else(PoisonError::into_inner);
        let slots = outputs.values().flat_map(HashMap::values);
        let mut all: Vec<OutputSummary> = slots.filter_map(|slot| slot.summary(now)).collect();
        all.sort_by(|one, other| one.name.cmp(&other.name));
        all
    }

    fn publish(
        &self,
        at: Time,
        (component, port): (&str, &str),
        topic: Option<&str>,
        sample: &dyn Sample,
    ) {
        let slot = {
            let outputs = self
                .0
                .outputs
                .read()
                .unwrap_or_else(PoisonError::into_inner);
            outputs
                .get(component)
                .and_then(|ports| ports.get(port))
                .cloned()
        };
        let slot = slot.unwrap_or_else(|| {
            let mut outputs = self
                .0
                .outputs
                .write()
                .unwrap_or_else(PoisonError::into_inner);
            let ports = outputs.entry(component.to_owned()).or_default();
            let new = || Arc::new(OutputSlot::new(format!("{component}.{port}")));
            Arc::clone(ports.entry(port.to_owned()).or_insert_with(new))
        });
        slot.publish(at, topic, sample);
        // a message on a topic is worth a line if it is an event, which is rare, and not a state
        if let Some(topic) = topic.filter(|_| slot.is_rare()) {
            let entry = log_entry::message(at, component, topic, sample);
            self.state().log.push(entry);
        }
    }
}

impl Observer for Feed {
    fn observe(&mut self, at: Time, event: &Event<'_>) {
        match event {
            Event::Published {
                component,
                port,
                topic,
                sample,
                ..
            } => {
                self.publish(at, (component, port), *topic, *sample);
                self.state().time = at;
                return;
            }
            Event::Report {
                component,
                kind,
                data,
            } if *kind == STEP_REPORT => {
                if let Ok(record) = data.to::<StepRecord>() {
                    let step = json!({ "t": at.seconds(), "component": component, "step": record });
                    let mut state = self.state();
                    state.time = at;
                    let step: Arc<str> = step.to_string().into();
                    state.steps.push(Arc::clone(&step));
                    let history = state.history.entry((*component).to_owned());
                    history.or_insert_with(|| Ring::new(HISTORY)).push(step);
                    let known = state.specifications.entry((*component).to_owned());
                    known.or_default().step(at, &record);
                }
                return;
            }
            // what is injected into an input is shown like what an output writes
            Event::Injected { target, sample, .. } => {
                if let Some((component, port)) = target.rsplit_once('.') {
                    self.publish(at, (component, port), None, *sample);
                }
            }
            Event::Cycle { .. }
            | Event::Called { .. }
            | Event::Answered { .. }
            | Event::Replied { .. }
            | Event::LifeCycle { .. }
            | Event::Fault { .. }
            | Event::Overrun { .. }
            | Event::Late { .. }
            | Event::Denied { .. }
            | Event::Dropped { .. }
            | Event::Property { .. }
            | Event::Report { .. }
            | Event::Lost { .. } => {}
        }
        let entry = log_entry::of(at, event);
        let mut state = self.state();
        state.time = at;
        if let Event::Lost { count } = event {
            state.lost += count;
        }
        let is_call = matches!(event, Event::Called { .. } | Event::Replied { .. });
        match entry {
            Some(entry) if is_call => state.calls.push(entry),
            Some(entry) => state.log.push(entry),
            None => {}
        }
    }
}
