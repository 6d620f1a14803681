//! A run that was recorded: its steps, log entries and samples, in memory and by time.
//!
//! A tab shows one moment: the newest samples up to then, and a window of steps and entries around it. The window has as much as a
//! tab can show, whatever the length of the run; the tab asks for the next one before it comes to its end.

mod components;
mod composition;
mod entry;
mod file;
mod moment;

use std::collections::BTreeMap;

use asmotion_component::Time;
use asmotion_coordinator::StepRecord;
use asmotion_recording::MessageData;

use self::components::RecordedComponents;
use crate::catalogue::SystemDescription;
use crate::log_entry::LogEntry;
use crate::specification_state::SpecificationState;

/// Number of steps between two stored states of a specification.
const STATE_EVERY: usize = 256;

/// A recorded run.
pub struct RecordedRun {
    pub(crate) system: SystemDescription,
    pub(crate) past: RunMoments,
}

impl RecordedRun {
    /// What is missing in the recording, in words; `None` if it is complete.
    pub fn problem(&self) -> Option<&str> {
        self.system.recording.as_ref()?.problem.as_deref()
    }
}

/// Everything that happened in a run, by time.
#[derive(Default)]
pub(crate) struct RunMoments {
    steps: BTreeMap<String, RecordedSteps>,
    /// Log entries without calls.
    log: Vec<RecordedEntry>,
    /// Log entries of calls and replies, which can be many.
    calls: Vec<RecordedEntry>,
    outputs: BTreeMap<String, RecordedOutput>,
    components: RecordedComponents,
    end: Time,
}

/// A line of the log.
struct RecordedEntry {
    at: Time,
    entry: LogEntry,
}

/// The samples of an output.
struct RecordedOutput {
    topic: Option<String>,
    kind: String,
    samples: Vec<(Time, MessageData)>,
}

/// The steps of a specification.
struct RecordedSteps {
    steps: Vec<(Time, StepRecord)>,
    /// Machines that began, by the index of their first step.
    begins: BTreeMap<usize, RecordedBegin>,
    /// The state before each step whose index is a multiple of [`STATE_EVERY`].
    states: Vec<SpecificationState>,
    /// The state after the last step.
    last: SpecificationState,
}

/// A machine that began.
struct RecordedBegin {
    /// Its state before its first step, as pairs of location and value.
    state: Vec<(String, String)>,
    /// Index of its specification among the versions that ran, oldest first.
    version: usize,
    /// Whether the machine continues in the state of its predecessor.
    continues: bool,
}

impl RecordedSteps {
    fn new(initial: &[(String, String)]) -> Self {
        Self {
            steps: Vec::new(),
            begins: BTreeMap::new(),
            states: Vec::new(),
            last: SpecificationState::initial(initial),
        }
    }

    /// Adds a step. `begin` is the machine that begins with it.
    fn push(&mut self, at: Time, record: StepRecord, begin: Option<RecordedBegin>) {
        let index = self.steps.len();
        if index.is_multiple_of(STATE_EVERY) {
            self.states.push(self.last.clone());
        }
        if let Some(begin) = begin {
            self.begins.insert(index, begin);
        }
        let mut state = std::mem::take(&mut self.last);
        self.apply(&mut state, index, at, &record);
        self.last = state;
        self.steps.push((at, record));
    }

    fn apply(&self, state: &mut SpecificationState, index: usize, at: Time, record: &StepRecord) {
        if let Some(begin) = self.begins.get(&index) {
            if begin.continues {
                state.continue_with(&begin.state);
            } else {
                state.begin_again(&begin.state);
            }
            let before = self.begins.range(..index).next_back();
            if before.is_some_and(|(_, before)| before.version != begin.version) {
                state.forget_places();
            }
        }
        state.step(at, record);
    }

    /// The state before the step with this index.
    fn state_before(&self, index: usize) -> SpecificationState {
        if index >= self.steps.len() {
            return self.last.clone();
        }
        let stored = index / STATE_EVERY;
        let mut state = self.states.get(stored).cloned().unwrap_or_default();
        for index in stored * STATE_EVERY..index {
            if let Some((at, record)) = self.steps.get(index) {
                self.apply(&mut state, index, *at, record);
            }
        }
        state
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asmotion_coordinator::UpdateRecord;

    fn step(number: u64) -> StepRecord {
        StepRecord {
            number,
            updates: vec![UpdateRecord {
                location: "n".to_owned(),
                before: (number - 1).to_string(),
                after: number.to_string(),
                place: "n.asm:1".to_owned(),
            }],
            ..StepRecord::default()
        }
    }

    fn value_of_n(state: &SpecificationState) -> String {
        let json = serde_json::to_value(state).expect("JSON");
        json["locations"]["n"]["value"]
            .as_str()
            .expect("n")
            .to_owned()
    }

    #[test]
    fn the_state_of_every_step_is_known_also_after_a_machine_has_begun_again() {
        let initial = [("n".to_owned(), "0".to_owned())];
        let mut recorded = RecordedSteps::new(&initial);
        for number in 1..=600 {
            recorded.push(Time::ZERO, step(number), None);
        }
        let begin = |version, continues| RecordedBegin {
            state: initial.to_vec(),
            version,
            continues,
        };
        recorded.push(Time::ZERO, step(1), Some(begin(0, false)));
        for index in [0, 1, 255, 256, 257, 511, 599, 600] {
            assert_eq!(value_of_n(&recorded.state_before(index)), index.to_string());
        }
        assert_eq!(value_of_n(&recorded.state_before(601)), "1");
    }
}
