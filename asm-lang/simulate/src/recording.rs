//! Runs again what a trace recorded: the same inputs, choices and times.

use crate::literal::Literals;
use asmotion_ir::{FunctionId, FunctionKind, Program};
use asmotion_machine::{Chooser, Environment, Machine};
use asmotion_value::Value;
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

/// A trace that was read, to be run again.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    steps: Vec<RecordedStep>,
    unread: UnreadInput,
}

/// What is said about an input that the recorded step did not read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum UnreadInput {
    /// The replay has gone another way than the recorded run.
    #[default]
    Astray,
    /// The recorded run had no inputs at all.
    Silent,
    /// Undef: another tool read its inputs in another order, and left out others.
    Undefined,
}

/// What caused a step.
#[derive(Clone, Debug, Default)]
pub struct RecordedStep {
    /// The time in nanoseconds.
    pub now_ns: i64,
    /// Location and value.
    inputs: Vec<(String, String)>,
    choices: Vec<usize>,
    unread: UnreadInput,
}

impl Recording {
    /// Reads the causes of the steps; all else is what a replay computes anew. A line `# reader …`
    /// says that another tool recorded them, and how it came by its inputs.
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
                        step.inputs.push((location.to_owned(), value.to_owned()));
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

    /// A step, from 0; one that was not recorded read nothing.
    pub fn step(&self, index: usize) -> RecordedStep {
        let recorded = self.steps.get(index).cloned();
        recorded.unwrap_or_else(|| self.unrecorded())
    }

    fn unrecorded(&self) -> RecordedStep {
        RecordedStep {
            unread: self.unread,
            ..RecordedStep::default()
        }
    }

    /// The steps, in order.
    pub fn steps(&self) -> &[RecordedStep] {
        &self.steps
    }
}

impl RecordedStep {
    /// The inputs of the step, for a machine that is about to do it.
    ///
    /// # Errors
    /// A line names no input of the machine, or gives it no value: the lines.
    pub fn inputs(&self, machine: &Machine) -> Result<RecordedInputs, Vec<String>> {
        let naming = machine.naming();
        let literals = Literals::new(naming.program, naming.reserve);
        let mut inputs = RecordedInputs {
            values: BTreeMap::new(),
            program: machine.program().clone(),
            unread: self.unread,
            ticks: Ticks::default(),
        };
        let mut unreadable = Vec::new();
        for (location, value) in &self.inputs {
            match literals.input(location, value) {
                Some((location, value)) => {
                    inputs.values.entry(location).or_default().push_back(value);
                }
                None => unreadable.push(format!("{location} = {value}")),
            }
        }
        if unreadable.is_empty() {
            Ok(inputs)
        } else {
            Err(unreadable)
        }
    }

    /// The choices of the step.
    pub fn choices(&self) -> RecordedChoices {
        RecordedChoices {
            indices: self.choices.clone(),
            at: 0,
        }
    }
}

/// The inputs of one recorded step. What was read several times in it (by the reference, which asks
/// again after an intermediate state) is answered in that order, the last answer for ever.
#[derive(Clone, Debug)]
pub struct RecordedInputs {
    values: BTreeMap<(FunctionId, Vec<Value>), VecDeque<Value>>,
    program: Arc<Program>,
    unread: UnreadInput,
    ticks: Ticks,
}

/// The clock of the reference: it moves on by one unit in every step that reads it, the unit being
/// that of the function read first.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ticks {
    passed_ns: i64,
    has_ticked: bool,
}

impl Ticks {
    /// The time in units of so many nanoseconds.
    fn tell(&mut self, unit_ns: i64) -> i64 {
        if !std::mem::replace(&mut self.has_ticked, true) {
            self.passed_ns = self.passed_ns.saturating_add(unit_ns);
        }
        self.passed_ns / unit_ns.max(1)
    }
}

impl RecordedInputs {
    /// The same, where another tool's clock stood after the step before.
    pub fn after(mut self, ticks: Ticks) -> Self {
        self.ticks = Ticks {
            has_ticked: false,
            ..ticks
        };
        self
    }

    /// Where another tool's clock stands now.
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
                Ok(Some(Value::Int(self.ticks.tell(unit_ns))))
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

/// The choices of one recorded step; beyond the last one the first candidate is taken.
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
