//! Reads a recorded run from its files.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::path::Path;
use std::sync::Arc;

use asmotion_component::Time;
use asmotion_coordinator::{MachineBegin, MachineOrigin, SourceRecord, StepRecord};
use asmotion_datum::Datum;
use asmotion_lang::MemoryFiles;
use asmotion_recording::{
    ChainedCycle, FileEnd, MessageData, RecordingError, RecordingItem, RunReader, part_path,
};
use asmotion_remote::CommandRecord;

use super::composition::{Composition, is_composition};
use super::entry::{NewEntry, of_call, of_event};
use super::{RecordedBegin, RecordedEntry, RecordedOutput, RecordedRun, RecordedSteps, RunMoments};
use crate::catalogue::SystemDescription;
use crate::log_entry::{self, LogLevel, brief_datum};
use crate::recording_description::RecordingDescription;

/// Limit on the number of marks on the line of time.
const MOST_MARKS: usize = 500;
/// Name of the channel with violated properties.
const MARKS: &str = "marks";
/// Name of the channel with commands from outside.
const COMMANDS: &str = "commands";
/// Name of the channel with the numbers of messages that wait.
const QUEUES: &str = "queues";
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
    /// Versions of the specifications that ran, oldest first, by component.
    versions: BTreeMap<String, Vec<SpecificationVersion>>,
    /// Names of the attached expansions of the composite.
    compositions: BTreeSet<String>,
    /// Name of the recorded process; empty if all components ran in one.
    process: String,
    /// The file ends as it was meant to.
    has_end: bool,
}

/// A version of a specification that a component executed.
struct SpecificationVersion {
    /// Its files, the main one first; empty if the recording does not say which they are.
    sources: Vec<SourceRecord>,
    /// Time of its first step.
    from: Time,
    /// The location of its control state; `None` without one.
    control: Option<String>,
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
        self.process = fact("process").unwrap_or_default();
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
            RecordingItem::Text { name, at, text } => {
                // each file of a recording has the texts of the first version again
                if is_composition(&name) && self.compositions.insert(name.clone()) {
                    self.composition(at, &text);
                }
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

    /// Takes a version of the composite.
    fn composition(&mut self, from: Time, text: &str) {
        let composition = Composition::read(text, &self.process);
        let components = &mut self.moments.components;
        components.follow(from, composition);
        let names = components.names();
        let names: Vec<_> = names
            .map(|(name, it)| (name.to_owned(), it.to_owned()))
            .collect();
        for (name, implementation) in names {
            self.system.describe_component(&name, &implementation);
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
        let begin = cycle.begins.into_iter().next_back();
        self.specification(component, at, &cycle.specification, begin.as_ref());
        if !is_intact {
            let words = format!("the record of step {} was changed", cycle.number);
            self.entry(
                at,
                &NewEntry::new(LogLevel::Error, "recording", component, words),
            );
        }
        let versions = self.versions.get(component).map_or(0, Vec::len);
        let begin = begin.map(|begin| RecordedBegin {
            state: begin.state.into_iter().collect(),
            version: versions.saturating_sub(1),
            continues: matches!(begin.from, MachineOrigin::Predecessor { .. }),
        });
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

    /// Describes the specification with which a component makes a step, unless it is that of the step before. `name` is that of the
    /// specification, and `begin` the machine that begins with this step.
    fn specification(
        &mut self,
        component: &str,
        at: Time,
        name: &str,
        begin: Option<&MachineBegin>,
    ) {
        let sources = begin.map(|begin| &*begin.sources).unwrap_or_default();
        let versions = self.versions.entry(component.to_owned()).or_default();
        let is_same = |last: &SpecificationVersion| {
            sources.is_empty() || is_same_text(&last.sources, sources)
        };
        if versions.last().is_some_and(is_same) {
            return;
        }
        let (main, files) = files_of(&self.texts, name, sources);
        let is_first = versions.is_empty();
        let from = if is_first { Time::ZERO } else { at };
        let described = self
            .system
            .add_specification(component, from, &main, &files);
        versions.push(SpecificationVersion {
            sources: sources.to_vec(),
            from,
            control: described.control,
        });
        if is_first {
            // without its beginning, the recording does not say in which state it was
            let known = if sources.is_empty() {
                Vec::new()
            } else {
                described.initial
            };
            let recorded = RecordedSteps::new(&known);
            self.moments.steps.insert(component.to_owned(), recorded);
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
                    let entry = entry.entry(at);
                    self.moments.calls.push(RecordedEntry { at, entry });
                }
            }
            // the caller's record says the same
            Some(("answer", _)) => {}
            Some(_) | None => {
                if let Ok(record) = data.datum() {
                    self.event(channel, at, &record);
                }
            }
        }
    }

    fn event(&mut self, channel: &str, at: Time, record: &Datum) {
        let text = |member: &str| {
            let value = record.get(member);
            value
                .and_then(|it| it.as_text().map(str::to_owned))
                .unwrap_or_default()
        };
        if channel == MARKS {
            let violation = (at.seconds(), text("component"), text("text"));
            self.recording.violations.push(violation);
            return;
        }
        if channel == COMMANDS {
            if let Ok(command) = record.to::<CommandRecord>() {
                let entry = log_entry::command(at, &command);
                if entry.level >= LogLevel::Warning {
                    self.mark(at, entry.level, &command.words());
                }
                self.moments.log.push(RecordedEntry { at, entry });
            }
            return;
        }
        if channel == QUEUES {
            self.moments.components.queues(at, record);
            return;
        }
        self.moments.components.event(at, record);
        if let Some(entry) = of_event(record) {
            self.system.add_component(&text("component"));
            self.entry(at, &entry);
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

    /// Marks a warning on the line of time.
    fn mark(&mut self, at: Time, level: LogLevel, text: &str) {
        let marks = &mut self.recording.marks;
        if marks.len() < MOST_MARKS {
            marks.push((at.seconds(), level.name(), text.to_owned()));
        }
    }

    fn entry(&mut self, at: Time, entry: &NewEntry) {
        if entry.level >= LogLevel::Warning {
            self.mark(at, entry.level, &entry.text);
        }
        let entry = entry.entry(at);
        self.moments.log.push(RecordedEntry { at, entry });
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
            versions,
            ..
        } = self;
        moments.log.sort_by_key(|entry| entry.at);
        moments.calls.sort_by_key(|entry| entry.at);
        for (component, versions) in versions {
            if let Some(recorded) = moments.steps.get(&component) {
                let changes = recorded.control_changes(&versions);
                recording.changes.insert(component, changes);
            }
        }
        for (name, output) in &moments.outputs {
            if output.kind == ODOMETRY {
                recording.trails.insert(name.clone(), output.trail());
            }
        }
        recording.end = moments.end.seconds();
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
                    entries.push((
                        *at,
                        NewEntry::new(LogLevel::Info, "message", component, words),
                    ));
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
    /// Changes of the control state: time, value before and after. Each version of the specification has its own location, and a
    /// machine that begins again may change it without a step.
    fn control_changes(&self, versions: &[SpecificationVersion]) -> Vec<(f64, String, String)> {
        let mut changes = Vec::new();
        let mut last: Option<String> = None;
        let mut change = |at: Time, before: Option<&str>, after: &str| {
            let known = last.take();
            if let Some(before) = before
                .or(known.as_deref())
                .filter(|before| *before != after)
            {
                changes.push((at.seconds(), before.to_owned(), after.to_owned()));
            }
            last = Some(after.to_owned());
        };
        for (index, (at, step)) in self.steps.iter().enumerate() {
            let version = versions.iter().rfind(|version| version.from <= *at);
            let Some(control) = version.and_then(|it| it.control.as_deref()) else {
                continue;
            };
            let begin = self.begins.get(&index).map(|begin| &begin.state);
            let began =
                begin.and_then(|state| state.iter().find(|(location, _)| location == control));
            if let Some((_, value)) = began {
                change(*at, None, value);
            }
            for update in step.updates.iter().filter(|it| it.location == control) {
                change(*at, Some(&update.before), &update.after);
            }
        }
        changes
    }
}

fn is_same_text(one: &[SourceRecord], other: &[SourceRecord]) -> bool {
    let key = |it: &SourceRecord| (it.path.clone(), it.hash.clone());
    one.iter().map(key).eq(other.iter().map(key))
}

/// The path of a specification and its files, of those that are attached. A part that continues another one does not say which files
/// its specifications have: all are given then.
fn files_of(
    texts: &BTreeMap<(String, String), Arc<str>>,
    name: &str,
    sources: &[SourceRecord],
) -> (String, MemoryFiles) {
    let main = match sources.first() {
        Some(main) => main.path.clone(),
        None => {
            let is_named = |path: &&String| Path::new(path).file_stem() == Some(OsStr::new(name));
            let named = texts.keys().map(|(_, path)| path).find(is_named);
            named.cloned().unwrap_or_default()
        }
    };
    let mut files = MemoryFiles::new();
    for ((hash, path), text) in texts {
        let is_source = |it: &SourceRecord| it.hash == *hash && it.path == *path;
        if sources.is_empty() || sources.iter().any(is_source) {
            files.add(path, Arc::clone(text));
        }
    }
    (main, files)
}

#[cfg(test)]
mod tests {
    use super::*;
    use asmotion_coordinator::UpdateRecord;

    fn step(location: &str, before: &str, after: &str) -> StepRecord {
        let update = UpdateRecord {
            location: location.to_owned(),
            before: before.to_owned(),
            after: after.to_owned(),
            ..UpdateRecord::default()
        };
        StepRecord {
            updates: vec![update],
            ..StepRecord::default()
        }
    }

    fn begin(location: &str, value: &str, version: usize, continues: bool) -> RecordedBegin {
        RecordedBegin {
            state: vec![(location.to_owned(), value.to_owned())],
            version,
            continues,
        }
    }

    #[test]
    fn the_control_state_changes_with_steps_resets_and_versions() {
        let at = |seconds: i64| Time::from_nanos(seconds * 1_000_000_000);
        let mut steps = RecordedSteps::new(&[]);
        steps.push(
            at(1),
            step("mode", "IDLE", "RUN"),
            Some(begin("mode", "IDLE", 0, false)),
        );
        steps.push(at(2), step("n", "1", "2"), None);
        // a reset, and another text with another location, whose first step does not write it
        steps.push(
            at(3),
            step("n", "0", "1"),
            Some(begin("mode", "IDLE", 0, false)),
        );
        steps.push(at(4), step("mode", "IDLE", "RUN"), None);
        steps.push(
            at(5),
            step("n", "1", "2"),
            Some(begin("phase", "REST", 1, true)),
        );
        steps.push(at(6), step("mode", "RUN", "IDLE"), None);
        steps.push(at(7), step("phase", "REST", "WORK"), None);
        let version = |from: i64, control: &str| SpecificationVersion {
            sources: Vec::new(),
            from: at(from),
            control: Some(control.to_owned()),
        };
        let changes = steps.control_changes(&[version(0, "mode"), version(5, "phase")]);
        let words: Vec<String> = changes
            .iter()
            .map(|(t, before, after)| format!("{t} {before} {after}"))
            .collect();
        let expected = [
            "1 IDLE RUN",
            "3 RUN IDLE",
            "4 IDLE RUN",
            "5 RUN REST",
            "7 REST WORK",
        ];
        assert_eq!(words, expected);
    }
}
