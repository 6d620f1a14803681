//! The feed: what is known of a system, written by its source and read by the tabs.
//!
//! The writer is the thread that passes events on. It never waits for a reader: each output keeps only its newest sample, and
//! steps and log entries are in rings, which a reader follows with a cursor of its own.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock};
use std::time::Instant;

use asmotion_component::Time;
use asmotion_coordinator::{STEP_REPORT, StepRecord};
use asmotion_datum::{Sample, Schema};
use asmotion_remote::{CommandOutcome, CommandRecord, Presence};
use asmotion_runtime::{Event, Observer};
use asmotion_viewer_encoding::ChannelSchema;
use serde::Deserialize;
use serde_json::json;
use tokio::sync::watch;

use crate::bus_link::BusLink;
use crate::catalogue::SystemDescription;
use crate::command_log::{CommandLog, CommandOrigin};
use crate::log_entry::{self, LogEntry};
use crate::output_slot::{OutputSlot, OutputSummary};
use crate::ring::Ring;
use crate::specification_state::SpecificationState;
use crate::step_guards::KnownStep;

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
    /// What the system consists of, of which tabs learn when it changes.
    system: watch::Sender<Arc<SystemDescription>>,
    /// By component, then by port: both are found without allocation.
    outputs: RwLock<HashMap<String, HashMap<String, Arc<OutputSlot>>>>,
    state: Mutex<FeedState>,
    /// Connections to other processes.
    links: Vec<BusLink>,
    /// Message types of ports, as `Component.port`.
    types: Mutex<BTreeMap<String, Schema>>,
}

/// The part of a feed that is read and written as a whole, under one lock.
pub(crate) struct FeedState {
    /// Time of the newest event.
    pub time: Time,
    /// Steps as JSON.
    pub steps: Ring<Arc<str>>,
    /// Log entries without calls.
    pub log: Ring<LogEntry>,
    /// Log entries of calls and replies, which can be many: they do not displace the others.
    pub calls: Ring<LogEntry>,
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
    commands: CommandLog,
}

/// A step as tabs receive it.
#[derive(Deserialize)]
struct ReportedStep {
    t: f64,
    step: StepRecord,
}

/// The time of a step or an entry, which is in seconds.
pub(crate) fn time(seconds: f64) -> Time {
    // a float has the nanoseconds of a hundred days
    Time::from_nanos((seconds * 1e9).round() as i64)
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
        Self::new(SystemDescription::default(), Vec::new())
    }
}

impl Feed {
    /// Creates a feed of a system.
    pub(crate) fn new(system: SystemDescription, links: Vec<BusLink>) -> Self {
        let initial = initial_states(&system);
        Self(Arc::new(FeedParts {
            began: Instant::now(),
            system: watch::Sender::new(Arc::new(system)),
            outputs: RwLock::default(),
            state: Mutex::new(FeedState {
                time: Time::ZERO,
                steps: Ring::new(STEPS),
                log: Ring::new(LOG),
                calls: Ring::new(CALLS),
                specifications: initial,
                history: BTreeMap::new(),
                presence: None,
                lost: 0,
                end: None,
                commands: CommandLog::new(),
            }),
            links,
            types: Mutex::default(),
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

    /// Follows the system to another version. Tabs begin again with it.
    pub fn follow(&self, system: SystemDescription) {
        let before = self.system();
        for (component, initial) in system.initial_states() {
            let mut state = self.state();
            let known = state.specifications.entry(component);
            let is_other = before.texts(known.key()) != system.texts(known.key());
            let functions = system.functions(known.key()).filter(|_| is_other);
            match (known, functions) {
                (Entry::Vacant(vacant), _) => {
                    vacant.insert(SpecificationState::initial(&initial));
                }
                (Entry::Occupied(mut known), Some(functions)) => {
                    known.get_mut().replace_text(&initial, functions);
                }
                (Entry::Occupied(_), None) => {}
            }
        }
        self.0.system.send_replace(Arc::new(system));
    }

    /// The connections to other processes.
    pub(crate) fn links(&self) -> &[BusLink] {
        &self.0.links
    }

    /// What the system consists of now.
    pub(crate) fn system(&self) -> Arc<SystemDescription> {
        Arc::clone(&self.0.system.borrow())
    }

    /// The versions of the system from now on.
    pub(crate) fn systems(&self) -> watch::Receiver<Arc<SystemDescription>> {
        self.0.system.subscribe()
    }

    /// Learns the message types of ports, as `Component.port`. Viewers receive samples of other ports as JSON without a schema.
    pub fn learn(&self, types: BTreeMap<String, Schema>) {
        self.types().extend(types);
        for slot in self.slots() {
            slot.forget_schema();
        }
    }

    fn types(&self) -> MutexGuard<'_, BTreeMap<String, Schema>> {
        self.0.types.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Ends the feed: the run has ended in this way.
    pub fn end(&self, outcome: &str) {
        self.state().end = Some(outcome.to_owned());
    }

    /// Advances to a time. Events of several threads can arrive in another order than that of their times.
    fn reach(&self, at: Time) {
        let mut state = self.state();
        state.time = state.time.max(at);
    }

    /// A step of a specification that is still known, with the state before it: the present one without the later updates.
    pub(crate) fn known_step(&self, component: &str, number: u64) -> Option<KnownStep> {
        let (steps, mut values) = {
            let state = self.state();
            let steps: Vec<Arc<str>> = state
                .history
                .get(component)?
                .since(0)
                .entries
                .cloned()
                .collect();
            let values = state.specifications.get(component)?.values();
            let owned = values.map(|(location, value)| (location.to_owned(), value.to_owned()));
            (steps, owned.collect::<BTreeMap<String, String>>())
        };
        // without the lock: a step is read from its text
        for step in steps.iter().rev() {
            let ReportedStep { t, step } = serde_json::from_str(step).ok()?;
            for update in &step.updates {
                values.insert(update.location.clone(), update.before.clone());
            }
            if step.number == number {
                return Some(KnownStep {
                    before: values.into_iter().collect(),
                    record: step,
                    at: time(t),
                });
            }
        }
        None
    }

    /// Notes that a tab asks for something.
    pub(crate) fn command(&self, origin: &CommandOrigin<'_>, text: &str) -> CommandRecord {
        let record = self.state().commands.asked(origin, text);
        self.note(record.clone());
        record
    }

    /// Notes what became of a command.
    pub(crate) fn command_ended(
        &self,
        command: &CommandRecord,
        outcome: CommandOutcome,
        reason: String,
    ) {
        self.note(command.ended(outcome, reason));
    }

    /// Notes that a command was refused at once.
    pub(crate) fn command_refused(&self, origin: &CommandOrigin<'_>, text: &str, reason: &str) {
        let record = self
            .state()
            .commands
            .refused(origin, (text, reason), Instant::now());
        if let Some(record) = record {
            self.note(record);
        }
    }

    fn note(&self, record: CommandRecord) {
        let mut state = self.state();
        let at = state.time;
        state.log.push(log_entry::command(at, &record));
        state.commands.keep(at, record);
    }

    /// Takes what tabs have asked for since the last call, and what became of it, each with the time of the run.
    pub fn take_commands(&self) -> Vec<(Time, CommandRecord)> {
        self.state().commands.take()
    }

    /// Shows a command that came from elsewhere, such as a tool.
    pub fn show_command(&self, at: Time, record: &CommandRecord) {
        let entry = log_entry::command(at, record);
        self.state().log.push(entry);
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
    pub(crate) fn slots(&self) -> Vec<Arc<OutputSlot>> {
        let outputs = self
            .0
            .outputs
            .read()
            .unwrap_or_else(PoisonError::into_inner);
        let mut slots: Vec<_> = outputs
            .values()
            .flat_map(HashMap::values)
            .cloned()
            .collect();
        slots.sort_by(|one, other| one.name.cmp(&other.name));
        slots
    }

    /// The type of the samples of an output for viewers; `None` before the first sample.
    pub(crate) fn schema_of(&self, slot: &OutputSlot) -> Option<Arc<ChannelSchema>> {
        let schema = self.types().get(&*slot.name).cloned();
        slot.schema(|kind| ChannelSchema::of_messages(kind, schema.as_ref()))
    }

    /// Summaries of all outputs that have written, by name.
    pub(crate) fn outputs(&self) -> Vec<OutputSummary> {
        let now = Instant::now();
        let slots = self.slots();
        slots.iter().filter_map(|slot| slot.summary(now)).collect()
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

/// The initial states of the specifications of a system, by component.
fn initial_states(system: &SystemDescription) -> BTreeMap<String, SpecificationState> {
    let initial = system.initial_states().into_iter();
    initial
        .map(|(component, locations)| (component, SpecificationState::initial(&locations)))
        .collect()
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
                self.reach(at);
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
                    state.time = state.time.max(at);
                    let known = state.specifications.entry((*component).to_owned());
                    if !known.or_default().step(at, &record) {
                        return;
                    }
                    let step: Arc<str> = step.to_string().into();
                    state.steps.push(Arc::clone(&step));
                    let history = state.history.entry((*component).to_owned());
                    history.or_insert_with(|| Ring::new(HISTORY)).push(step);
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
        state.time = state.time.max(at);
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
