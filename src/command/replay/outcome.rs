//! The results of replays.

use std::collections::BTreeMap;
use std::path::PathBuf;

use asmotion_component::Time;
use asmotion_recording::{InputChange, LocationWriter, ReplayCounts, StepDifference};

use super::export::Exported;
use asmotion_remote::CommandRecord;

use crate::exit::Exit;

/// The verdict about a replay. Of several, the greatest one counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ReplayVerdict {
    /// A process of a system that has its coordinators in other processes.
    Skipped,
    /// Every step that was compared is equal, and there was one.
    Equal,
    /// A step is different.
    Different,
    /// Nothing could be compared.
    Unusable,
}

impl ReplayVerdict {
    /// The exit code.
    pub fn exit(self) -> Exit {
        match self {
            Self::Equal => Exit::Ok,
            Self::Different => Exit::Findings,
            // alone, it is no success
            Self::Skipped | Self::Unusable => Exit::Usage,
        }
    }

    /// The verdict as a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Skipped => "skipped",
            Self::Equal => "equal",
            Self::Different => "different",
            Self::Unusable => "unusable",
        }
    }
}

/// The result for a recording.
#[derive(Default)]
pub struct RecordingOutcome {
    /// The first file.
    pub path: PathBuf,
    /// Facts about the run.
    pub facts: BTreeMap<String, String>,
    /// What others asked of the system, and what became of it, by time.
    pub commands: Vec<(Time, CommandRecord)>,
    /// Its coordinators, by name.
    pub coordinators: BTreeMap<String, CoordinatorOutcome>,
    /// The reason that nothing of it was compared.
    pub failure: Option<String>,
    /// It is whole, and has no step of a coordinator.
    pub has_no_steps: bool,
    /// It is the recording of a process without coordinator.
    pub is_skipped: bool,
    /// The reason that it ends before its run.
    pub cut: Option<String>,
    /// Number of messages of the run that are not in it, if it has an end.
    pub lost: u64,
}

/// The result for a coordinator.
#[derive(Default)]
pub struct CoordinatorOutcome {
    /// Name of the specification.
    pub specification: String,
    /// Figures about the replay.
    pub counts: ReplayCounts,
    /// Number of its steps that are not in the recording, as counted by the recording.
    pub lost: u64,
    /// The first difference.
    pub difference: Option<StepDifference>,
    /// The reason that it cannot be replayed.
    pub failure: Option<String>,
    /// What an edited specification could not be given, with the first step.
    pub notes: Vec<(String, u64)>,
    /// The state in which the replay stopped.
    pub state: Option<ReachedState>,
    /// Explanation of a location.
    pub explanation: Option<Explained>,
    /// Export of its steps.
    pub export: Option<Result<Exported, String>>,
}

/// The state after a step.
pub struct ReachedState {
    /// Number of the step; 0 before the first one.
    pub number: u64,
    /// Time of the step in the run.
    pub time_ns: i64,
    /// Locations with their values.
    pub locations: Vec<(String, String)>,
    /// Inputs of the step with their values.
    pub inputs: BTreeMap<String, String>,
}

/// The explanation of a location.
pub enum Explained {
    /// A step wrote it.
    Written(Box<LocationWriter>),
    /// It is an input, and has changed last then.
    Input(InputChange),
    /// No step wrote it. Its value, unless it is undef.
    Initial(String, Option<String>),
}

impl CoordinatorOutcome {
    /// The verdict about the coordinator.
    pub fn verdict(&self) -> ReplayVerdict {
        if self.failure.is_some() {
            ReplayVerdict::Unusable
        } else if self.difference.is_some() {
            ReplayVerdict::Different
        } else if self.counts.compared == 0 {
            ReplayVerdict::Unusable
        } else {
            ReplayVerdict::Equal
        }
    }

    /// The reason that nothing was compared.
    pub fn reason(&self) -> Option<String> {
        if let Some(failure) = &self.failure {
            return Some(failure.clone());
        }
        let is_unusable = self.verdict() == ReplayVerdict::Unusable;
        is_unusable.then(|| match self.counts.not_compared {
            0 => "it has no step up to there".to_owned(),
            _ => "its steps are recorded from the middle of the run: a replay needs the first one"
                .to_owned(),
        })
    }
}

impl RecordingOutcome {
    /// The result for a file that is no recording.
    pub fn refused(path: PathBuf, failure: String) -> Self {
        Self {
            path,
            failure: Some(failure),
            ..Self::default()
        }
    }

    /// The verdict about the recording.
    pub fn verdict(&self) -> ReplayVerdict {
        if self.is_skipped {
            return ReplayVerdict::Skipped;
        }
        if self.failure.is_some() {
            return ReplayVerdict::Unusable;
        }
        let coordinators = self.coordinators.values();
        let verdict = coordinators.map(CoordinatorOutcome::verdict).max();
        verdict.unwrap_or(ReplayVerdict::Unusable)
    }

    /// Describes what is missing; `None` if the recording is complete.
    pub fn missing(&self) -> Option<String> {
        let mut missing = Vec::new();
        match self.lost {
            0 => {}
            1 => missing.push("1 message of the run is not in it".to_owned()),
            lost => missing.push(format!("{lost} messages of the run are not in it")),
        }
        missing.extend(self.cut.clone());
        let coordinators = self.coordinators.values();
        let coordinators = coordinators.filter(|one| one.difference.is_none());
        match coordinators.map(|one| one.counts.not_compared).sum() {
            0_u64 => {}
            1 => missing.push("1 step could not be compared".to_owned()),
            steps => missing.push(format!("{steps} steps could not be compared")),
        }
        (!missing.is_empty()).then(|| missing.join("; "))
    }

    /// The fact with this name, if it is not empty.
    pub fn fact(&self, name: &str) -> Option<&str> {
        let fact = self.facts.get(name).map(String::as_str);
        fact.filter(|fact| !fact.is_empty())
    }
}

/// A process of a composite need not have a coordinator, if another one that is replayed has.
pub fn accept_processes_without_coordinator(outcomes: &mut [RecordingOutcome]) {
    let composite = |one: &RecordingOutcome| one.fact("composite").map(str::to_owned);
    let with_steps = outcomes.iter().filter(|one| !one.coordinators.is_empty());
    let known: Vec<_> = with_steps.filter_map(composite).collect();
    for one in outcomes.iter_mut() {
        let is_process = one.fact("process").is_some() && one.has_no_steps;
        let is_known = composite(one).is_some_and(|it| known.contains(&it));
        one.is_skipped = is_process && is_known;
    }
}
