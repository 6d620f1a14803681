//! Reads a recorded run from its files.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::Path;
use std::sync::Arc;

use asmotion_component::Time;
use asmotion_coordinator::{MachineOrigin, RecordedCycle, StepRecord};
use asmotion_datum::Datum;
use asmotion_lang::MemoryFiles;
use asmotion_recording::{
    ChainedCycle, FileEnd, MessageData, RecordingError, RecordingItem, RunReader, part_path,
};

use super::entry::{NewEntry, of_call, of_event};
use super::{RecordedEntry, RecordedOutput, RecordedRun, RecordedSteps, RunMoments};
use crate::catalogue::SystemDescription;
use crate::log_entry::brief_datum;
use crate::recording_description::RecordingDescription;
use crate::rendering::quoted;

/// Limit on the number of marks.
const MARKS: usize = 500;
/// Mean interval from which the messages of a topic are events, in seconds of the run.
const RARE_S: f64 = 0.5;
/// Distance from which a path gets another point, in m, and the time after which it does in any case, in s.
const PATH_STEP: (f64, f64) = (0.05, 0.2);
/// Type of the samples of which a path is made.
const ODOMETRY: &str = "nav_msgs/Odometry";

/// A run, as far as its files have been read.
#[derive(Default)]
struct RunBuilder {
    system: SystemDescription,
    recording: RecordingDescription,
    /// Texts of specifications by hash and path.
    texts: BTreeMap<(String, String), Arc<str>>,
    moments: RunMoments,
    /// The file ends as it was meant to.
    has_end: bool,
}

impl RecordedRun {
    /// Reads the recording that begins with this file, and the files that continue it.
    ///
    /// # Errors
    /// The file cannot be read, or is no recording of a run.
    pub fn read(path: &Path) -> Result<Self, RecordingError> {
        let mut reader = RunReader::open(path)?;
        let mut builder = RunBuilder::default();
        builder.describe(path, &reader);
        loop {
            let mut next = None;
            for item in reader.by_ref() {
                if let RecordingItem::End(end) = &item {
                    next = end.continues;
                }
                builder.add(item);
            }
            let Some(number) = next else {
                break;
            };
            let part = part_path(path, number);
            match RunReader::open(&part) {
                Ok(following) => reader = following,
                Err(error) => {
                    builder.problem(format!("`{}` {error}", part.display()));
                    builder.has_end = true;
                    break;
                }
            }
        }
        Ok(builder.finish())
    }
}

impl RunBuilder {
    fn describe(&mut self, path: &Path, reader: &RunReader) {
        let facts = reader.facts();
        let fact = |name: &str| facts.get(name).filter(|it| !it.is_empty()).cloned();
        self.system.name = fact("composite").unwrap_or_default();
        self.system.profile = fact("profile");
        let clock = fact("clock").unwrap_or_default();
        let started = fact("started").unwrap_or_default();
        self.system.clock = format!("recording of {started}, {clock} clock");
        self.recording.file = path.display().to_string();
        if reader.part() > 1 {
            self.problem(format!("it begins with part {}", reader.part()));
        }
    }

    fn problem(&mut self, words: String) {
        let known = self.recording.problem.take();
        self.recording.problem = Some(match known {
            Some(known) => format!("{known}; {words}"),
            None => words,
        });
    }

    fn add(&mut self, item: RecordingItem) {
        match item {
            RecordingItem::Text { name, text } => {
                let source = name.strip_prefix("specification/");
                if let Some((hash, path)) = source.and_then(|source| source.split_once('/')) {
                    let key = (hash.to_owned(), path.to_owned());
                    self.texts.insert(key, text.into());
                }
            }
            RecordingItem::Step { component, step } => self.step(&component, *step),
            RecordingItem::Message { channel, at, data } => self.message(&channel, at, data),
            RecordingItem::End(end) => self.end(&end),
            RecordingItem::Cut(reason) => {
                self.has_end = true;
                self.problem(format!("the file is cut: {reason}"));
            }
        }
    }

    fn end(&mut self, end: &FileEnd) {
        self.has_end = true;
        if end.lost > 0 {
            self.problem(format!("{} messages are lost", end.lost));
        }
        if let Some(failure) = &end.failure {
            self.problem(failure.clone());
        }
    }

    fn passed(&mut self, at: Time) {
        self.moments.end = self.moments.end.max(at);
    }

    fn step(&mut self, component: &str, step: ChainedCycle) {
        let ChainedCycle {
            cycle, is_intact, ..
        } = step;
        let at = Time::from_nanos(cycle.time_ns);
        self.passed(at);
        self.system.add_component(component);
        if !self.moments.steps.contains_key(component) {
            let initial = self.specification(component, &cycle);
            let recorded = RecordedSteps::new(&initial);
            self.moments.steps.insert(component.to_owned(), recorded);
        }
        if !is_intact {
            let words = format!("the record of step {} was changed", cycle.number);
            self.entry(at, &NewEntry::new("error", "recording", component, words));
        }
        // a state that was taken over continues in that of its predecessor
        let begin = cycle.begins.into_iter().next_back();
        let begin = begin.filter(|begin| !matches!(begin.from, MachineOrigin::Predecessor { .. }));
        let begin = begin.map(|begin| begin.state.into_iter().collect());
        let record = StepRecord {
            specification: cycle.specification,
            number: cycle.number,
            inputs: cycle
                .read
                .into_iter()
                .map(|it| (it.location, it.value))
                .collect(),
            choices: cycle
                .choices
                .into_iter()
                .map(|it| (it.index, it.of))
                .collect(),
            updates: cycle.updates,
            safe_rule: cycle.replaced.map(|it| it.rule),
        };
        if let Some(recorded) = self.moments.steps.get_mut(component) {
            recorded.push(at, record, begin);
        }
    }

    /// Describes the specification of a component, from its first step. Returns its initial state; nothing if its beginning is not
    /// recorded.
    fn specification(&mut self, component: &str, first: &RecordedCycle) -> Vec<(String, String)> {
        let mut files = MemoryFiles::new();
        let sources = first.begins.last().map(|begin| &*begin.sources);
        let sources = sources.unwrap_or_default();
        let main = match sources.first() {
            Some(main) => main.path.clone(),
            // a part that continues another one does not say which text is that of the component
            None => {
                let is_named = |path: &&String| {
                    Path::new(path).file_stem() == Some(OsStr::new(&first.specification))
                };
                let named = self.texts.keys().map(|(_, path)| path).find(is_named);
                named.cloned().unwrap_or_default()
            }
        };
        for ((hash, path), text) in &self.texts {
            if sources.is_empty()
                || sources
                    .iter()
                    .any(|it| it.hash == *hash && it.path == *path)
            {
                files.add(path, Arc::clone(text));
            }
        }
        let initial = self.system.add_specification(component, &main, &files);
        if sources.is_empty() {
            Vec::new()
        } else {
            initial
        }
    }

    fn message(&mut self, channel: &str, at: Time, data: MessageData) {
        self.passed(at);
        match channel.split_once('/') {
            Some(("topic", topic)) => self.sample(Some(topic), at, data),
            Some(("port", _)) => self.sample(None, at, data),
            Some(("call", caller)) => {
                let entry = data
                    .datum()
                    .ok()
                    .and_then(|record| of_call(caller, &record));
                if let Some(entry) = entry {
                    let json = entry.json(at);
                    self.moments.calls.push(RecordedEntry { at, json });
                }
            }
            // the caller's record says the same
            Some(("answer", _)) => {}
            Some(_) | None => {
                let record = data.datum().ok();
                if let Some(entry) = record.as_ref().and_then(of_event) {
                    if let Some(component) = record.as_ref().and_then(|it| it.get("component")) {
                        self.system
                            .add_component(component.as_text().unwrap_or_default());
                    }
                    self.entry(at, &entry);
                }
            }
        }
    }

    fn sample(&mut self, topic: Option<&str>, at: Time, data: MessageData) {
        // a topic may be written from outside: views expect the name of a port
        let port = data.port().filter(|port| port.contains('.'));
        let name = port.map_or_else(
            || format!("outside.{}", topic.unwrap_or_default()),
            str::to_owned,
        );
        if let Some((component, _)) = port.and_then(|port| port.rsplit_once('.')) {
            self.system.add_component(component);
        }
        let outputs = &mut self.moments.outputs;
        let output = outputs.entry(name).or_insert_with(|| RecordedOutput {
            topic: topic.map(str::to_owned),
            kind: data.type_name().to_owned(),
            samples: Vec::new(),
        });
        output.samples.push((at, data));
    }

    fn entry(&mut self, at: Time, entry: &NewEntry) {
        let marks = &mut self.recording.marks;
        if ["warning", "error"].contains(&entry.level) && marks.len() < MARKS {
            marks.push((at.seconds(), entry.level, entry.text.clone()));
        }
        let json = entry.json(at);
        self.moments.log.push(RecordedEntry { at, json });
    }

    fn finish(mut self) -> RecordedRun {
        if !self.has_end {
            self.problem("it has no end".to_owned());
        }
        self.rare_messages();
        let Self {
            mut system,
            mut recording,
            mut moments,
            ..
        } = self;
        moments.log.sort_by_key(|entry| entry.at);
        moments.calls.sort_by_key(|entry| entry.at);
        for (component, location) in system.control_states() {
            let changes = moments
                .steps
                .get(&component)
                .map(|it| it.changes(&location));
            recording
                .changes
                .insert(component, changes.unwrap_or_default());
        }
        for (name, output) in &moments.outputs {
            if output.kind == ODOMETRY {
                recording.trails.insert(name.clone(), output.trail());
            }
        }
        recording.end = moments.end.seconds();
        moments.outputs_json = outputs_json(&moments.outputs);
        system.recording = Some(recording);
        RecordedRun {
            system,
            past: moments,
        }
    }

    /// Adds entries of messages that are events, and not a state that is published again and again.
    fn rare_messages(&mut self) {
        let mut entries = Vec::new();
        for (name, output) in &self.moments.outputs {
            let Some(topic) = output.topic.as_ref().filter(|_| output.is_rare()) else {
                continue;
            };
            let component = name.rsplit_once('.').map_or("", |(component, _)| component);
            for (at, data) in &output.samples {
                if let Ok(datum) = data.datum() {
                    let words = format!("{topic} {}", brief_datum(&datum, &output.kind));
                    entries.push((*at, NewEntry::new("info", "message", component, words)));
                }
            }
        }
        for (at, entry) in entries {
            self.entry(at, &entry);
        }
    }
}

impl RecordedOutput {
    /// Samples per second; `None` before the second one.
    fn rate_hz(&self) -> Option<f64> {
        let (first, last) = (self.samples.first()?.0, self.samples.last()?.0);
        let span = last.since(first).as_secs_f64();
        (span > 0.0).then(|| (self.samples.len() - 1) as f64 / span)
    }

    fn is_rare(&self) -> bool {
        self.rate_hz().is_none_or(|rate| rate * RARE_S <= 1.0)
    }

    /// The driven path: time, x, y and yaw.
    fn trail(&self) -> Vec<[f64; 4]> {
        let mut trail: Vec<[f64; 4]> = Vec::new();
        for (at, data) in &self.samples {
            let Some(pose) = data.datum().ok().as_ref().and_then(pose) else {
                continue;
            };
            let [x, y, yaw] = pose;
            let is_new = trail.last().is_none_or(|[t, last_x, last_y, _]| {
                at.seconds() - t > PATH_STEP.1 || (x - last_x).hypot(y - last_y) > PATH_STEP.0
            });
            if is_new {
                trail.push([at.seconds(), x, y, yaw]);
            }
        }
        trail
    }
}

/// Position and heading of an odometry message.
fn pose(odometry: &Datum) -> Option<[f64; 3]> {
    let number = |path: &str| odometry.get(&format!("pose.pose.{path}"))?.as_float();
    let (z, w) = (number("orientation.z")?, number("orientation.w")?);
    let (x, y) = (number("orientation.x")?, number("orientation.y")?);
    let yaw = (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z));
    Some([number("position.x")?, number("position.y")?, yaw])
}

impl RecordedSteps {
    /// Changes of a location: time, value before and after.
    fn changes(&self, location: &str) -> Vec<(f64, String, String)> {
        let updates = self.steps.iter().flat_map(|(at, step)| {
            let changed = step.updates.iter();
            let changed = changed.filter(|it| it.location == location && it.before != it.after);
            changed.map(|it| (at.seconds(), it.before.clone(), it.after.clone()))
        });
        updates.collect()
    }
}

/// Names, types and rates of outputs, in the form of a running system.
fn outputs_json(outputs: &BTreeMap<String, RecordedOutput>) -> String {
    let output = |(name, it): (&String, &RecordedOutput)| {
        let topic = it
            .topic
            .as_ref()
            .map_or_else(|| "null".to_owned(), |it| quoted(it));
        let rate = it
            .rate_hz()
            .map_or_else(|| "null".to_owned(), |rate| format!("{rate:.3}"));
        format!(
            "{{\"name\":{},\"type\":{},\"topic\":{topic},\"n\":{},\"hz\":{rate},\"age_ms\":0,\"stale\":false}}",
            quoted(name),
            quoted(&it.kind),
            it.samples.len(),
        )
    };
    let outputs: Vec<String> = outputs.iter().map(output).collect();
    format!("[{}]", outputs.join(","))
}
