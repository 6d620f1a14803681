//! Replay: repeats a recorded run with the same inputs, choices and times.

use crate::literal::Literals;
use crate::recorded_message::{RecordedMessage, UnfitMessage};
use asmotion_ir::{FunctionId, FunctionKind, Program};
use asmotion_machine::{Chooser, Environment, Machine};
use asmotion_value::Value;
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

/// The inputs, choices and times of a trace.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    steps: Vec<RecordedStep>,
    unread: UnreadInput,
}

/// The value of an input that the recorded step did not read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum UnreadInput {
    /// An error: the replay deviates from the recorded run.
    #[default]
    Astray,
    /// No value: the recorded run had no inputs at all.
    Silent,
    /// Undef: the recording tool reads inputs in a different order and may skip some.
    Undefined,
    /// As without an environment: the recording has the values of all bound locations, whether the step read them or not.
    Unbound,
}

/// Locations and their values, as text.
pub type InputTexts = Vec<(String, String)>;

/// The inputs, choices and time of a recorded step.
#[derive(Clone, Debug, Default)]
pub struct RecordedStep {
    /// The time of the step in nanoseconds.
    pub now_ns: i64,
    /// Shared by steps with the same inputs.
    inputs: Arc<InputTexts>,
    choices: Vec<usize>,
    /// Messages and failures that reached the machine before the step.
    messages: Vec<RecordedMessage>,
    unread: UnreadInput,
}

impl Recording {
    /// Reads a trace. Only inputs, choices and times are used; a replay computes everything else. A
    /// line `# reader …` marks the recording of another tool, and tells how that tool reads inputs.
    pub fn read(text: &str) -> Self {
        let mut recording = Self::default();
        for line in text.lines() {
            let Some((word, rest)) = line.split_once(' ') else {
                continue;
            };
            if word == "@step" {
                recording.steps.push(recording.unrecorded());
            }
            let Some(step) = recording.steps.last_mut() else {
                match rest.strip_prefix("reader ") {
                    Some("none") => recording.unread = UnreadInput::Silent,
                    Some(_) => recording.unread = UnreadInput::Undefined,
                    None => {}
                }
                continue;
            };
            match word {
                "T" => step.now_ns = rest.trim().parse().unwrap_or_default(),
                "M" => {
                    if let Some((location, value)) = rest.split_once(" = ") {
                        let input = (location.to_owned(), value.to_owned());
                        Arc::make_mut(&mut step.inputs).push(input);
                    }
                }
                "C" => {
                    let index = rest
                        .split(' ')
                        .next()
                        .and_then(|index| index.parse::<usize>().ok());
                    step.choices.extend(index);
                }
                _ => {}
            }
        }
        recording
    }

    /// Returns the step with an index, from 0. A step beyond the recording has no inputs.
    pub fn step(&self, index: usize) -> RecordedStep {
        let recorded = self.steps.get(index).cloned();
        recorded.unwrap_or_else(|| self.unrecorded())
    }

    /// Returns a recording of these steps.
    pub fn of_steps(steps: Vec<RecordedStep>) -> Self {
        let unread = steps.first().map(|step| step.unread).unwrap_or_default();
        Self { steps, unread }
    }

    fn unrecorded(&self) -> RecordedStep {
        RecordedStep {
            unread: self.unread,
            ..RecordedStep::default()
        }
    }

    /// Returns all recorded steps in order.
    pub fn steps(&self) -> &[RecordedStep] {
        &self.steps
    }
}

impl RecordedStep {
    /// Returns a step with the values of all bound inputs, and with the messages that reached the machine before it.
    pub fn with_frame(
        now_ns: i64,
        inputs: Arc<InputTexts>,
        choices: Vec<usize>,
        messages: Vec<RecordedMessage>,
    ) -> Self {
        Self {
            now_ns,
            inputs,
            choices,
            messages,
            unread: UnreadInput::Unbound,
        }
    }

    /// Returns whether messages reached the machine before the step.
    pub fn has_messages(&self) -> bool {
        !self.messages.is_empty()
    }

    /// Passes the messages before the step to a machine.
    ///
    /// # Errors
    /// The text in a message that denotes no value of the machine's program.
    pub fn deliver(&self, machine: &mut Machine) -> Result<(), UnfitMessage> {
        self.messages
            .iter()
            .try_for_each(|message| message.apply(machine))
    }

    /// Returns the inputs of the step for a machine that is about to execute it.
    ///
    /// # Errors
    /// The lines that name no input of the machine, or give it an invalid value.
    pub fn inputs(&self, machine: &Machine) -> Result<RecordedInputs, Vec<String>> {
        let (inputs, unreadable) = self.readable_inputs(machine);
        if unreadable.is_empty() {
            Ok(inputs)
        } else {
            Err(unreadable)
        }
    }

    /// Returns the inputs of the step as far as they fit a machine that is about to execute it, and the lines that name no input of
    /// the machine or give it an invalid value.
    pub fn readable_inputs(&self, machine: &Machine) -> (RecordedInputs, Vec<String>) {
        let naming = machine.naming();
        let literals = Literals::new(naming.program, naming.reserve);
        let mut inputs = RecordedInputs {
            values: BTreeMap::new(),
            program: machine.program().clone(),
            unread: self.unread,
            ticks: Ticks::default(),
        };
        let mut unreadable = Vec::new();
        for (location, value) in &*self.inputs {
            match literals.input(location, value) {
                Some((location, value)) => {
                    inputs.values.entry(location).or_default().push_back(value);
                }
                None => unreadable.push(format!("{location} = {value}")),
            }
        }
        (inputs, unreadable)
    }

    /// Returns the choices of the step.
    pub fn choices(&self) -> RecordedChoices {
        RecordedChoices {
            indices: self.choices.clone(),
            at: 0,
        }
    }
}

/// The inputs of a recorded step. Several values for one location (the reference reads again after
/// an intermediate state) are returned in order, and the last one from then on.
#[derive(Clone, Debug)]
pub struct RecordedInputs {
    values: BTreeMap<(FunctionId, Vec<Value>), VecDeque<Value>>,
    program: Arc<Program>,
    unread: UnreadInput,
    ticks: Ticks,
}

/// The clock of the reference simulator. It advances in each step that reads it, by one unit of the
/// function that is read first.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ticks {
    passed_ns: i64,
    has_ticked: bool,
}

impl Ticks {
    /// Returns the time in units of `unit_ns` nanoseconds.
    fn time_in(&mut self, unit_ns: i64) -> i64 {
        if !std::mem::replace(&mut self.has_ticked, true) {
            self.passed_ns = self.passed_ns.saturating_add(unit_ns);
        }
        self.passed_ns / unit_ns.max(1)
    }
}

impl RecordedInputs {
    /// Sets the state of the reference's clock after the previous step.
    pub fn after(mut self, ticks: Ticks) -> Self {
        self.ticks = Ticks {
            has_ticked: false,
            ..ticks
        };
        self
    }

    /// Returns the state of the reference's clock.
    pub fn ticks(&self) -> Ticks {
        self.ticks
    }
}

impl Environment for RecordedInputs {
    fn read(&mut self, function: FunctionId, arguments: &[Value]) -> Result<Option<Value>, String> {
        let key = (function, arguments.to_vec());
        let declared = &self.program.functions[function.0 as usize];
        let is_owed = declared.kind == FunctionKind::Monitored && declared.clock.is_none();
        let known = self.values.get_mut(&key).and_then(|answers| {
            if answers.len() > 1 {
                return answers.pop_front();
            }
            answers.front().cloned()
        });
        match (known, self.unread, declared.clock) {
            (None, UnreadInput::Silent | UnreadInput::Undefined, Some(unit_ns)) => {
                Ok(Some(Value::Int(self.ticks.time_in(unit_ns))))
            }
            (None, UnreadInput::Astray, _) if is_owed => {
                Err("the recorded step did not read it".to_owned())
            }
            (None, UnreadInput::Silent, _) => Err("the recorded run has no inputs".to_owned()),
            (known, ..) => Ok(known),
        }
    }

    fn source(&self, _function: FunctionId, _arguments: &[Value]) -> String {
        "the recorded step".to_owned()
    }
}

/// The choices of a recorded step; the first candidate once they are used up.
#[derive(Clone, Debug, Default)]
pub struct RecordedChoices {
    indices: Vec<usize>,
    at: usize,
}

impl Chooser for RecordedChoices {
    fn choose(&mut self, _count: usize) -> usize {
        let index = self.indices.get(self.at).copied().unwrap_or(0);
        self.at += 1;
        index
    }
}
