//! Records a mission.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use asmotion_component::Time;
use asmotion_datum::Schema;
use asmotion_plan::{Opened, Plan, RecordReaders};
use asmotion_recording::{Overflow, RecorderOptions, RecordingFile, RecordingProfile, RunRecorder};
use asmotion_remote::CommandRecord;
use asmotion_runtime::{Run, System};

use super::{RecordedMission, RecordingResult};
use crate::mission::message_types::port_types;

/// A recording in progress, if there is one.
#[derive(Default)]
pub(in crate::mission) struct MissionRecorder {
    recorder: Option<RunRecorder>,
    /// The reason that the recording which the composite asks for did not begin.
    failure: Option<String>,
    /// Number of versions of the composite after the first one.
    followed: u32,
    /// Messages that waited when this was last recorded.
    waiting: BTreeMap<String, u64>,
    /// Time at which they are counted next.
    next_count: Time,
}

/// Interval at which the messages that wait are counted.
const COUNT: Duration = Duration::from_secs(1);

/// Bytes of a megabyte, the unit of `rotate_mb`.
const MEGABYTE: u64 = 1_000_000;

impl MissionRecorder {
    /// Starts the recording that the command line or the composite asks for, and lets it observe the system.
    ///
    /// # Errors
    /// The file of the command line cannot be created. A system whose composite asks for a recording runs without it: a robot
    /// with a full disk starts all the same.
    pub fn start(
        mission: &RecordedMission<'_>,
        opened: &Opened,
        plan: &Plan,
        system: &mut System,
    ) -> Result<Self, String> {
        let Some((file, options)) = mission.recorder_options(opened, plan) else {
            return Ok(Self::default());
        };
        match RunRecorder::start(file, options) {
            Ok(recorder) => {
                system.observe(recorder.observer());
                Ok(Self {
                    recorder: Some(recorder),
                    ..Self::default()
                })
            }
            Err(failure) if mission.request.file.is_some() => Err(failure.to_string()),
            Err(failure) => Ok(Self {
                failure: Some(failure.to_string()),
                ..Self::default()
            }),
        }
    }

    /// Follows the system to another version of the composite, whose texts the recording contains as `version/2/…`.
    pub fn follow(&mut self, at: Time, opened: &Opened, plan: &Plan) {
        let Some(recorder) = &self.recorder else {
            return;
        };
        self.followed += 1;
        let number = self.followed + 1;
        let texts = texts(opened, plan).into_iter();
        let texts = texts.map(|(name, text)| (format!("version/{number}/{name}"), text));
        recorder.follow(at, texts.collect(), types(plan));
    }

    /// Records what others asked of the system.
    pub fn commands(&mut self, commands: &[(Time, CommandRecord)]) {
        let Some(recorder) = &self.recorder else {
            return;
        };
        for (at, command) in commands {
            // every record is representable
            if let Ok(command) = serde_json::to_value(command) {
                recorder.command(*at, &command);
            }
        }
    }

    /// Counts the messages that wait, once a second, and records them if they are others than before.
    pub fn queues(&mut self, run: &dyn Run) {
        let now = run.now();
        let Some(recorder) = self.recorder.as_ref().filter(|_| now >= self.next_count) else {
            return;
        };
        self.next_count = now + COUNT;
        let waiting = waiting(run);
        if waiting != self.waiting {
            recorder.queues(now, &waiting);
            self.waiting = waiting;
        }
    }

    /// Ends the recording, after the system.
    pub fn finish(self) -> Option<RecordingResult> {
        let Some(recorder) = self.recorder else {
            let result = |failure| RecordingResult {
                paths: Vec::new(),
                bytes: 0,
                lost: 0,
                failure: Some(failure),
                unmatched: Vec::new(),
            };
            return self.failure.map(result);
        };
        let (end, unmatched) = recorder.finish();
        Some(RecordingResult {
            paths: end.paths,
            bytes: end.bytes,
            lost: end.lost,
            failure: end.failure.map(|failure| failure.to_string()),
            unmatched,
        })
    }
}

/// The inputs, services and components at which messages wait, with their numbers.
fn waiting(run: &dyn Run) -> BTreeMap<String, u64> {
    let mut all = BTreeMap::new();
    for component in run.components() {
        let Some(declared) = run.declaration(&component) else {
            continue;
        };
        let inputs = declared.inputs.iter().map(|it| &it.name);
        let services = declared.services.iter().map(|it| &it.name);
        let counts = inputs
            .zip(run.waiting(&component))
            .chain(services.zip(run.waiting_requests(&component)));
        let counts = counts.map(|(end, count)| (format!("{component}.{end}"), count));
        all.extend(counts.filter(|(_, count)| *count > 0));
        let inside = run.waiting_inside(&component);
        if inside > 0 {
            all.insert(component, inside);
        }
    }
    all
}

impl RecordedMission<'_> {
    /// Returns the file of the recording and its options; `None` if nothing is recorded.
    fn recorder_options(
        &self,
        opened: &Opened,
        plan: &Plan,
    ) -> Option<(RecordingFile, RecorderOptions)> {
        let record = plan
            .record
            .as_ref()
            .filter(|_| self.request.follows_composite);
        let now = SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .unwrap_or_default();
        let now_ns = u64::try_from(now.as_nanos()).unwrap_or_default();
        let (overflow, epoch_ns) = if self.is_virtual {
            // equal runs give equal times
            (Overflow::Wait, 0)
        } else {
            (Overflow::Count, now_ns)
        };
        let shared = RecorderOptions {
            profile: self.request.profile,
            overflow,
            epoch_ns,
            facts: self.run_facts(opened, plan, now_ns),
            texts: texts(opened, plan),
            types: types(plan),
            ..RecorderOptions::default()
        };
        if let Some(file) = &self.request.file {
            let ports = self.request.ports.clone();
            return Some((
                RecordingFile::new(file),
                RecorderOptions { ports, ..shared },
            ));
        }
        let record = record?;
        let folder = Path::new(&opened.path).parent().unwrap_or(Path::new(""));
        let process = self.process.map(|process| format!("-{process}"));
        let name = plan.name.replace('/', "_");
        let name = format!(
            "{name}{}-{}.mcap",
            process.unwrap_or_default(),
            utc_stamp(now_ns)
        );
        let options = RecorderOptions {
            ports: record.topics.clone(),
            calls: record.calls,
            steps: record.asm_states,
            rotate_bytes: Some(record.rotate_mb.saturating_mul(MEGABYTE)),
            profile: match record.readers {
                RecordReaders::Viewers => RecordingProfile::Viewers,
                RecordReaders::Ros2 => RecordingProfile::Ros2,
            },
            ..shared
        };
        let file = folder.join(&record.dir).join(name);
        Some((RecordingFile::new(file), options))
    }

    /// Facts about the run for the recording.
    fn run_facts(&self, opened: &Opened, plan: &Plan, now_ns: u64) -> BTreeMap<String, String> {
        let clock = if self.is_virtual { "virtual" } else { "wall" };
        let facts = [
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("composite", plan.name.clone()),
            ("file", opened.path.clone()),
            ("profile", self.profile.unwrap_or_default().to_owned()),
            ("process", self.process.unwrap_or_default().to_owned()),
            ("clock", clock.to_owned()),
            ("seed", self.seed.to_string()),
            ("set", self.settings.join("\n")),
            ("started", utc_stamp(now_ns)),
        ];
        let facts = facts.into_iter();
        facts
            .map(|(name, value)| (name.to_owned(), value))
            .collect()
    }
}

/// The texts of the composite, its nested composites and other files that it names, and the composite with everything expanded.
fn texts(opened: &Opened, plan: &Plan) -> BTreeMap<String, String> {
    let sources = &opened.sources;
    let paths = sources.paths().filter(|path| !path.starts_with('<'));
    let texts = paths.filter_map(|path| {
        let text = sources.text(sources.find(path)?).to_owned();
        Some((format!("composite/{path}"), text))
    });
    let expanded = asmotion_plan::expand(opened, plan);
    texts
        .chain([("expanded.composite.toml".to_owned(), expanded)])
        .collect()
}

/// The message types of ports and topics.
fn types(plan: &Plan) -> BTreeMap<String, Schema> {
    let topics = plan.topics.iter();
    let topics = topics.filter_map(|topic| {
        let schema = plan.types.get(topic.kind.as_ref()?)?;
        Some((format!("topic:{}", topic.name), schema.clone()))
    });
    port_types(plan).into_iter().chain(topics).collect()
}

/// Formats a time since 1970 as in `20261126T151617Z`.
fn utc_stamp(since_1970_ns: u64) -> String {
    let seconds = since_1970_ns / 1_000_000_000;
    let (days, rest) = (seconds / 86_400, seconds % 86_400);
    let (year, month, day) = civil_date(days);
    let (hour, minute, second) = (rest / 3600, rest / 60 % 60, rest % 60);
    format!("{year:04}{month:02}{day:02}T{hour:02}{minute:02}{second:02}Z")
}

/// The date of a number of days after 1970-01-01, in the Gregorian calendar. Years are counted from March, so that the leap
/// day is the last one: Howard Hinnant, *chrono-Compatible Low-Level Date Algorithms*.
fn civil_date(days: u64) -> (u64, u64, u64) {
    let days = days + 719_468;
    let (era, day_of_era) = (days / 146_097, days % 146_097);
    let year_of_era =
        (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    (year, month, day)
}

#[cfg(test)]
mod tests {
    use super::utc_stamp;

    #[test]
    fn a_time_is_a_date_in_utc() {
        for (seconds, stamp) in [
            (0, "19700101T000000Z"),
            (951_782_399, "20000228T235959Z"),
            (951_782_400, "20000229T000000Z"),
            (1_795_706_177, "20261126T151617Z"),
            (4_107_542_400, "21000301T000000Z"),
        ] {
            assert_eq!(utc_stamp(seconds * 1_000_000_000), stamp);
        }
    }
}
