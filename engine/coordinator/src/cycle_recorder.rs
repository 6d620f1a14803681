//! Collects what a cycle of a coordinator depends on, for a recording.
//!
//! The cycle pays for it: so only inputs that differ from those of the step before become text, and everything else, such as
//! hashes, is left to the recorder.

use crate::frame::InputFrame;
use crate::recorded::{CycleCauses, MachineBegin, MachineOrigin, SourceRecord};
use crate::typed_input::TypedInput;
use crate::watch::Watch;
use asmotion_component::{Cycle, Flow, Time};
use asmotion_lang::Specification;
use asmotion_lang::machine::Machine;
use asmotion_lang::simulate::{self, RecordedMessage};
use asmotion_lang::value::Value;
use std::collections::BTreeMap;

/// The causes of the next step of a coordinator, as far as they are known.
#[derive(Debug, Default)]
pub(crate) struct CycleRecorder {
    /// Names of the bound locations, by their position in the frame; empty before the first step.
    names: Vec<String>,
    /// The inputs of the step before.
    before: Vec<Option<Value>>,
    /// Machines that were replaced before their first step.
    replaced: Vec<MachineBegin>,
    /// The origin of the machine, until its first step is recorded.
    begin: Option<MachineOrigin>,
    messages: Vec<RecordedMessage>,
    cause: Vec<String>,
}

impl CycleRecorder {
    /// Starts recording a machine with this origin.
    pub fn new(origin: MachineOrigin) -> Self {
        Self {
            begin: Some(origin),
            ..Self::default()
        }
    }

    /// Continues with another machine of the same coordinator.
    pub fn begin(&mut self, origin: MachineOrigin) {
        self.before.clear();
        self.begin = Some(origin);
        // they reached the machine before
        self.messages.clear();
    }

    /// Starts recording a machine that continues in the state of a predecessor, which this recorder belongs to.
    pub fn after(&self, predecessor: RecordedMachine<'_>, origin: MachineOrigin) -> Self {
        let machine = predecessor.machine;
        let mut replaced = self.replaced.clone();
        if let Some(from) = self.begin.clone() {
            replaced.push(predecessor.begin(from));
        }
        // the new machine has the messages of a predecessor that has made a step, and nothing of another one
        let messages = match machine.steps() {
            0 => Vec::new(),
            _ => self.messages.clone(),
        };
        Self {
            replaced,
            begin: Some(origin),
            messages,
            ..Self::default()
        }
    }

    /// Notes new data that a cycle has found.
    pub fn note_cause(&mut self, name: impl Into<String>) {
        self.cause.push(name.into());
    }

    /// Notes the ports with new samples.
    pub fn note_ports(&mut self, ports: &[TypedInput], cycle: &Cycle<'_>) {
        let new = ports
            .iter()
            .filter(|input| matches!(cycle.read(input.port), Flow::NewData(_)));
        self.cause.extend(new.map(|input| input.name.clone()));
    }

    /// Notes a message that reached the machine.
    pub fn note_message(&mut self, message: RecordedMessage) {
        self.messages.push(message);
    }

    /// Returns the causes of a step that the machine is about to make.
    pub fn causes(&mut self, of: RecordedMachine<'_>, frame: &InputFrame) -> CycleCauses {
        let mut begins = std::mem::take(&mut self.replaced);
        if let Some(from) = self.begin.take() {
            begins.push(of.begin(from));
        }
        CycleCauses {
            cause: std::mem::take(&mut self.cause),
            begins,
            messages: std::mem::take(&mut self.messages),
            frame: self.changed_inputs(of.machine, frame),
        }
    }

    /// Returns the inputs that differ from those of the step before.
    fn changed_inputs(
        &mut self,
        machine: &Machine,
        frame: &InputFrame,
    ) -> BTreeMap<String, String> {
        if self.names.len() != frame.values().len() {
            self.names = frame.names(machine);
        }
        self.before.resize(frame.values().len(), None);
        let mut changed = BTreeMap::new();
        let inputs = self.names.iter().zip(frame.values()).zip(&mut self.before);
        for ((name, value), before) in inputs {
            if value != before {
                before.clone_from(value);
                changed.insert(name.clone(), shown(value.as_ref(), machine));
            }
        }
        changed
    }
}

/// Returns all inputs by name.
pub(crate) fn all_inputs(machine: &Machine, frame: &InputFrame) -> BTreeMap<String, String> {
    let values = frame.values().iter();
    let values = values.map(|value| shown(value.as_ref(), machine));
    frame.names(machine).into_iter().zip(values).collect()
}

fn shown(value: Option<&Value>, machine: &Machine) -> String {
    match value {
        Some(value) => value.show(&machine.naming()).to_string(),
        None => Value::Undef.show(&machine.naming()).to_string(),
    }
}

/// The inputs at the replacement of a coordinator, as the origin of its successor's machine.
pub(crate) fn replacement(machine: &Machine, frame: &InputFrame, now: Time) -> MachineOrigin {
    MachineOrigin::Predecessor {
        time_ns: now.nanos(),
        frame: all_inputs(machine, frame),
    }
}

/// A machine as it begins, with what is known about it.
#[derive(Clone, Copy)]
pub(crate) struct RecordedMachine<'a> {
    pub specification: &'a Specification,
    pub machine: &'a Machine,
    /// Elements that stand for services outside.
    pub agents: &'a [Value],
    pub watch: &'a Watch,
}

impl RecordedMachine<'_> {
    fn begin(self, from: MachineOrigin) -> MachineBegin {
        let Self {
            specification,
            machine,
            agents,
            watch,
        } = self;
        let naming = machine.naming();
        let agents = agents.iter().map(|agent| agent.show(&naming).to_string());
        let sources = &specification.sources;
        // texts in angle brackets are embedded libraries and terms of the binding
        let paths = sources.paths().filter(|path| !path.starts_with('<'));
        let sources = paths.filter_map(|path| {
            Some(SourceRecord {
                path: path.to_owned(),
                text: sources.text(sources.find(path)?).to_owned(),
                hash: String::new(),
            })
        });
        MachineBegin {
            from,
            agents: agents.collect(),
            sources: sources.collect(),
            state: simulate::state(machine).into_iter().collect(),
            watch: watch.clone(),
        }
    }
}
