//! The observer that turns the events of a run into messages of a recording.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use asmotion_component::{CallError, CallId, Time};
use asmotion_coordinator::{
    BRIEF_STEP_REPORT, FAILED_STEP_REPORT, RECORDED_CYCLE_REPORT, RecordedCycle, STEP_REPORT,
    VIOLATION_REPORT, ViolationRecord,
};
use asmotion_datum::{Datum, Sample, Schema};
use asmotion_runtime::{Event, Observer, ReportInterest};
use asmotion_viewer_encoding::{ChannelSchema, RosType};
use serde_json::{Value, json};

use super::chain::{StepChain, text_hash};
use super::channels::{ChannelKind, ChannelTable};
use super::event_record::{datum_json, event_record};
use super::options::{RecorderOptions, RecordingFile};
use super::queue::{AttachedText, ChannelAbout, JobQueue, WriterJob};
use super::schemas;
use super::writer::{PORT, RecordingEnd, RecordingFailure, RecordingWriter};
use crate::pattern::PortPatterns;

/// A recording of a run in progress. Pass [`observer`](Self::observer) to the system before it runs, and call
/// [`finish`](Self::finish) after it has stopped.
///
/// | channel | messages |
/// |---|---|
/// | `topic/NAME` | samples that components publish to a topic |
/// | `port/COMPONENT.PORT` | samples of other outputs, and samples that arrive at an input from outside |
/// | `call/COMPONENT.REFERENCE.OPERATION` | requests, and the replies or faults that end them, with the duration |
/// | `answer/COMPONENT.SERVICE.OPERATION` | replies of the provider |
/// | `asm/COMPONENT/step` | steps of a coordinator, [`RecordedCycle`]s with [hashes](super::StepHashes) |
/// | `events` | life cycle, faults, losses, reports |
///
/// Samples of types of ROS 2 are in CDR, all other messages are JSON with a JSON Schema. See
/// [`RecordingProfile`](crate::RecordingProfile) for other readers.
#[derive(Debug)]
pub struct RunRecorder {
    path: PathBuf,
    queue: Arc<JobQueue>,
    counts: Arc<RecordingCounts>,
    types: SharedTypes,
    options: RecorderOptions,
    thread: Option<JoinHandle<RecordingEnd>>,
}

/// Message types of ports and topics. They grow when the system changes, and are read when a channel begins.
type SharedTypes = Arc<Mutex<BTreeMap<String, Schema>>>;

/// Figures that the observer writes and the end of the recording states.
#[derive(Debug, Default)]
struct RecordingCounts {
    /// Messages of the run, whether recorded or not.
    messages: AtomicU64,
    /// For each coordinator, the number and the hash of its last record, and of those that were lost.
    coordinators: Mutex<BTreeMap<String, CoordinatorCount>>,
    /// Patterns that selected nothing.
    unmatched: Mutex<Vec<String>>,
}

#[derive(Debug, Default)]
struct CoordinatorCount {
    last_hash: String,
    records: u64,
    lost: u64,
}

impl RecordingCounts {
    fn coordinators(&self) -> MutexGuard<'_, BTreeMap<String, CoordinatorCount>> {
        let counts = self.coordinators.lock();
        counts.unwrap_or_else(PoisonError::into_inner)
    }

    /// The facts at the end of the recording.
    fn end_facts(&self) -> BTreeMap<String, String> {
        let mut facts = BTreeMap::new();
        let messages = self.messages.load(Ordering::Relaxed);
        facts.insert("messages".to_owned(), messages.to_string());
        for (component, count) in &*self.coordinators() {
            let key = |fact: &str| format!("{component}.{fact}");
            facts.insert(key("records"), count.records.to_string());
            facts.insert(key("lost"), count.lost.to_string());
            facts.insert(key("last_hash"), count.last_hash.clone());
        }
        facts
    }
}

impl RunRecorder {
    /// Creates the file and starts the thread that writes it.
    ///
    /// # Errors
    /// The file cannot be created or written.
    pub fn start(file: RecordingFile, options: RecorderOptions) -> Result<Self, RecordingFailure> {
        let queue = Arc::new(JobQueue::new(options.overflow));
        let counts = Arc::new(RecordingCounts::default());
        let writer = RecordingWriter::new(Arc::clone(&queue), options.clone(), file)?;
        let path = writer.path().unwrap_or_default();
        let end_counts = Arc::clone(&counts);
        let thread = std::thread::Builder::new().name("recorder".to_owned());
        let thread = thread.spawn(move || writer.run(&|| end_counts.end_facts()));
        Ok(Self {
            path,
            queue,
            counts,
            types: Arc::new(Mutex::new(options.types.clone())),
            options,
            thread: Some(thread.map_err(|_| RecordingFailure::Thread)?),
        })
    }

    /// Path of the first file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the observer of the run. There should be one.
    pub fn observer(&self) -> impl Observer + use<> {
        RecordingObserver {
            queue: Arc::clone(&self.queue),
            counts: Arc::clone(&self.counts),
            patterns: PortPatterns::new(&self.options.ports),
            types: Arc::clone(&self.types),
            options: self.options.clone(),
            channels: ChannelTable::default(),
            chains: BTreeMap::new(),
            calls: BTreeMap::new(),
        }
    }

    /// Follows a system to its next version from this time on: attaches its texts, and learns the types of its ports and topics.
    pub fn follow(
        &self,
        at: Time,
        texts: BTreeMap<String, String>,
        types: BTreeMap<String, Schema>,
    ) {
        locked(&self.types).extend(types);
        for (name, text) in texts {
            let at_ns = u64::try_from(at.nanos()).unwrap_or_default();
            let text = AttachedText { name, text, at_ns };
            self.queue.push_always(WriterJob::Attachment { text });
        }
    }

    /// Ends the recording, after the run. Returns also the patterns of ports that published nothing.
    pub fn finish(mut self) -> (RecordingEnd, Vec<String>) {
        let mut end = self.close().unwrap_or_else(|| RecordingEnd {
            failure: Some(RecordingFailure::Thread),
            ..RecordingEnd::default()
        });
        let messages = self.counts.messages.load(Ordering::Relaxed);
        end.lost = messages.saturating_sub(end.messages);
        let unmatched = self.counts.unmatched.lock();
        let unmatched = unmatched.unwrap_or_else(PoisonError::into_inner).clone();
        (end, unmatched)
    }
}

impl RunRecorder {
    /// Lets the thread write what is in the queue, and end.
    fn close(&mut self) -> Option<RecordingEnd> {
        self.queue.close();
        self.thread.take()?.join().ok()
    }
}

/// Ends the file of a run that did not begin.
impl Drop for RunRecorder {
    fn drop(&mut self) {
        self.close();
    }
}

struct RecordingObserver {
    queue: Arc<JobQueue>,
    counts: Arc<RecordingCounts>,
    patterns: PortPatterns,
    types: SharedTypes,
    options: RecorderOptions,
    channels: ChannelTable,
    /// The chain of each coordinator.
    chains: BTreeMap<String, StepChain>,
    /// The calls under way, by caller and number, with the times of their first attempts.
    calls: BTreeMap<(String, CallId), Time>,
}

/// Reports that say the same as the recorded cycle.
const STEP_REPORTS: &[&str] = &[STEP_REPORT, BRIEF_STEP_REPORT, FAILED_STEP_REPORT];

impl Observer for RecordingObserver {
    fn reports(&self) -> ReportInterest {
        if self.options.steps {
            ReportInterest::Except(STEP_REPORTS)
        } else {
            ReportInterest::All
        }
    }

    fn observe(&mut self, at: Time, event: &Event<'_>) {
        match event {
            Event::Published {
                component,
                port,
                topic,
                sample,
                ..
            } => self.sample(at, component, port, *topic, *sample),
            Event::Injected { target, sample, .. } => self.injected(at, target, *sample),
            Event::Called { .. } | Event::Answered { .. } | Event::Replied { .. } => {
                if self.options.calls {
                    self.call(at, event);
                }
            }
            Event::Report {
                component,
                kind,
                data,
            } if *kind == RECORDED_CYCLE_REPORT => self.step(at, component, data),
            Event::Report {
                component,
                kind,
                data,
            } if *kind == VIOLATION_REPORT => {
                self.mark(at, component, data);
                self.event(at, event);
            }
            // part of the recorded cycle
            Event::Report { kind, .. } if STEP_REPORTS.contains(kind) && self.options.steps => {}
            Event::Lost { count } => {
                self.counts.messages.fetch_add(*count, Ordering::Relaxed);
                self.event(at, event);
            }
            Event::Cycle { .. }
            | Event::LifeCycle { .. }
            | Event::Fault { .. }
            | Event::Overrun { .. }
            | Event::Late { .. }
            | Event::Denied { .. }
            | Event::Dropped { .. }
            | Event::Property { .. }
            | Event::Report { .. } => self.event(at, event),
        }
    }
}

/// Publishes which patterns selected nothing.
impl Drop for RecordingObserver {
    fn drop(&mut self) {
        let unmatched = self.counts.unmatched.lock();
        let mut unmatched = unmatched.unwrap_or_else(PoisonError::into_inner);
        *unmatched = self.patterns.unmatched().map(str::to_owned).collect();
    }
}

impl RecordingObserver {
    fn sample(
        &mut self,
        at: Time,
        component: &str,
        port: &str,
        topic: Option<&str>,
        sample: &dyn Sample,
    ) {
        let (kind, owner, name) = match topic {
            Some(topic) => (ChannelKind::Topic, "", topic),
            None => (ChannelKind::Port, component, port),
        };
        if !self.channels.is_known(kind, owner, name) {
            let place = format!("{component}.{port}");
            let is_wanted = match topic {
                Some(topic) => self.patterns.select(&[&place, topic]),
                None => self.patterns.select(&[&place]),
            };
            let channel = topic.map(|topic| format!("topic/{topic}"));
            let channel = channel.unwrap_or_else(|| format!("port/{place}"));
            let about = is_wanted.then(|| self.of_messages(channel, &place, topic, sample));
            self.add_channel(kind, owner, name, about);
        }
        self.message(at, (kind, owner, name), |ros| {
            RosType::encode_or_json(ros, sample)
        });
    }

    /// Records a sample from outside of the system: of a topic, or of a port (`Component.port`).
    fn injected(&mut self, at: Time, target: &str, sample: &dyn Sample) {
        let is_topic = || locked(&self.types).contains_key(&topic_key(target));
        let is_port = target.contains('.') && !is_topic();
        let (kind, channel) = if is_port {
            (ChannelKind::Port, format!("port/{target}"))
        } else {
            (ChannelKind::Topic, format!("topic/{target}"))
        };
        let (owner, name) = match target.rsplit_once('.').filter(|_| is_port) {
            Some((component, port)) => (component, port),
            None => ("", target),
        };
        if !self.channels.is_known(kind, owner, name) {
            let is_wanted = self.patterns.select(&[target]);
            let topic = (!is_port).then_some(target);
            let about = is_wanted.then(|| self.of_messages(channel, target, topic, sample));
            self.add_channel(kind, owner, name, about);
        }
        self.message(at, (kind, owner, name), |ros| {
            RosType::encode_or_json(ros, sample)
        });
    }

    /// The description of a channel of samples.
    fn of_messages(
        &self,
        channel: String,
        place: &str,
        topic: Option<&str>,
        sample: &dyn Sample,
    ) -> ChannelAbout {
        let types = locked(&self.types);
        let of_topic = topic.and_then(|topic| types.get(&topic_key(topic)));
        let schema = types.get(place).or(of_topic);
        ChannelAbout {
            topic: channel,
            schema: ChannelSchema::of_messages(sample.type_name(), schema),
            facts: vec![(PORT, place.to_owned())],
        }
    }

    fn call(&mut self, at: Time, event: &Event<'_>) {
        match event {
            Event::Called {
                component,
                reference,
                operation,
                call,
                attempt,
                argument,
            } => {
                let key = ((*component).to_owned(), *call);
                self.calls.entry(key).or_insert(at);
                let name = format!("{reference}.{operation}");
                let record = json!({
                    "phase": "call", "call": call.0, "attempt": attempt,
                    "argument": sample_json(*argument),
                });
                self.about_call(at, (ChannelKind::Call, component, &name), &record);
            }
            Event::Replied {
                component,
                reference,
                operation,
                call,
                result,
            } => {
                let began = self.calls.remove(&((*component).to_owned(), *call));
                let duration = began.map(|began| at.since(began).as_secs_f64());
                let name = format!("{reference}.{operation}");
                let mut record = outcome(result);
                record["phase"] = if result.is_ok() { "reply" } else { "fault" }.into();
                record["call"] = call.0.into();
                record["duration_s"] = json!(duration);
                self.about_call(at, (ChannelKind::Call, component, &name), &record);
            }
            Event::Answered {
                component,
                service,
                operation,
                caller,
                result,
            } => {
                let name = format!("{service}.{operation}");
                let mut record = outcome(result);
                record["caller"] = (*caller).into();
                self.about_call(at, (ChannelKind::Answer, component, &name), &record);
            }
            Event::Cycle { .. }
            | Event::Published { .. }
            | Event::Injected { .. }
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
    }

    fn about_call(
        &mut self,
        at: Time,
        (kind, component, name): (ChannelKind, &str, &str),
        record: &Value,
    ) {
        if !self.channels.is_known(kind, component, name) {
            let (channel, schema) = if kind == ChannelKind::Call {
                ("call", schemas::call())
            } else {
                ("answer", schemas::answer())
            };
            let about = ChannelAbout {
                topic: format!("{channel}/{component}.{name}"),
                schema,
                facts: vec![("component", component.to_owned())],
            };
            self.add_channel(kind, component, name, Some(about));
        }
        self.message(at, (kind, component, name), |_| {
            Some(record.to_string().into_bytes())
        });
    }

    fn event(&mut self, at: Time, event: &Event<'_>) {
        let Some(record) = event_record(event) else {
            return;
        };
        let place = (ChannelKind::Event, "", "");
        if !self.channels.is_known(place.0, place.1, place.2) {
            let about = ChannelAbout {
                topic: "events".to_owned(),
                schema: schemas::event(),
                facts: Vec::new(),
            };
            self.add_channel(place.0, place.1, place.2, Some(about));
        }
        self.message(at, place, |_| Some(record.to_string().into_bytes()));
    }

    /// Marks a violation, so that readers find it without reading everything before it.
    fn mark(&mut self, at: Time, component: &str, data: &Datum) {
        let Ok(violation) = data.to::<ViolationRecord>() else {
            return;
        };
        let place = (ChannelKind::Mark, "", "");
        if !self.channels.is_known(place.0, place.1, place.2) {
            let about = ChannelAbout {
                topic: "marks".to_owned(),
                schema: schemas::mark(),
                facts: Vec::new(),
            };
            self.add_channel(place.0, place.1, place.2, Some(about));
        }
        let mark = json!({
            "kind": "violation", "component": component, "step": violation.step, "text": violation.to_string(),
        });
        self.message(at, place, |_| Some(mark.to_string().into_bytes()));
    }

    fn step(&mut self, at: Time, component: &str, data: &Datum) {
        if !self.options.steps {
            return;
        }
        let place = (ChannelKind::Step, component, "");
        if !self.channels.is_known(place.0, place.1, place.2) {
            let about = ChannelAbout {
                topic: format!("asm/{component}/step"),
                schema: schemas::step(),
                facts: vec![("component", component.to_owned())],
            };
            self.add_channel(place.0, place.1, place.2, Some(about));
            self.chains
                .insert(component.to_owned(), StepChain::default());
        }
        let text = data.to().ok().and_then(|mut cycle: RecordedCycle| {
            self.attach_sources(&mut cycle);
            let chain = self.chains.get_mut(component)?;
            chain.link(&cycle).ok()
        });
        let is_recorded =
            text.is_some_and(|text| self.message(at, place, |_| Some(text.into_bytes())));
        let mut counts = self.counts.coordinators();
        if !counts.contains_key(component) {
            counts.insert(component.to_owned(), CoordinatorCount::default());
        }
        if let Some(count) = counts.get_mut(component) {
            count.records += 1;
            count.lost += u64::from(!is_recorded);
            count.last_hash = self
                .chains
                .get(component)
                .map(StepChain::last)
                .unwrap_or_default();
        }
    }

    /// Replaces the texts of specifications by hashes, and attaches them.
    fn attach_sources(&self, cycle: &mut RecordedCycle) {
        let sources = cycle.begins.iter_mut().flat_map(|begin| &mut begin.sources);
        for source in sources {
            let text = std::mem::take(&mut source.text);
            source.hash = text_hash(&text);
            let text = AttachedText {
                name: format!("specification/{}/{}", source.hash, source.path),
                text,
                at_ns: u64::try_from(cycle.time_ns).unwrap_or_default(),
            };
            self.queue.push_always(WriterJob::Attachment { text });
        }
    }

    fn add_channel(
        &mut self,
        kind: ChannelKind,
        owner: &str,
        name: &str,
        about: Option<ChannelAbout>,
    ) {
        let number = self.channels.add(kind, owner, name, about.as_ref());
        if let (Some(channel), Some(about)) = (number, about) {
            self.queue
                .push_always(WriterJob::Channel { channel, about });
        }
    }

    /// Queues a message of a known channel. Returns `false` if it is lost.
    fn message(
        &mut self,
        at: Time,
        (kind, owner, name): (ChannelKind, &str, &str),
        data: impl FnOnce(Option<&RosType>) -> Option<Vec<u8>>,
    ) -> bool {
        let Some(place) = self.channels.next(kind, owner, name) else {
            // left out by the patterns
            return true;
        };
        self.counts.messages.fetch_add(1, Ordering::Relaxed);
        let Some(data) = data(place.ros.as_deref()) else {
            return false;
        };
        self.queue.push(WriterJob::Message {
            channel: place.channel,
            at_ns: u64::try_from(at.nanos()).unwrap_or_default(),
            sequence: place.sequence,
            data,
        })
    }
}

fn locked(types: &SharedTypes) -> MutexGuard<'_, BTreeMap<String, Schema>> {
    types.lock().unwrap_or_else(PoisonError::into_inner)
}

fn topic_key(topic: &str) -> String {
    format!("topic:{topic}")
}

/// The result of a call.
fn outcome(result: &Result<&dyn Sample, &CallError>) -> Value {
    match result {
        Ok(response) => json!({ "result": sample_json(*response) }),
        Err(error) => json!({ "error": error.to_string() }),
    }
}

fn sample_json(sample: &dyn Sample) -> Value {
    let datum = sample.to_datum();
    datum.as_ref().map(datum_json).unwrap_or_default()
}
