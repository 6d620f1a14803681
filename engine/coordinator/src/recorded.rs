//! A cycle of a coordinator as it is recorded: the causes of its step, from which a machine repeats it, and the effects.

use crate::step::{UpdateRecord, update_records};
use crate::violation::ViolationRecord;
use crate::watch::Watch;
use asmotion_lang::Specification;
use asmotion_lang::machine::{Machine, Step};
use asmotion_lang::simulate::{self, RecordedMessage};
use asmotion_lang::value::Value;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Kind of the report that contains a [`RecordedCycle`].
pub const RECORDED_CYCLE_REPORT: &str = "asm/Cycle";

/// A cycle of a coordinator, which is a step of its specification. Values are texts in the notation of the language.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RecordedCycle {
    /// Name of the specification.
    pub specification: String,
    /// Number of the step, from 1. A step that failed has no number of its own: the next one has the same.
    pub number: u64,
    /// Time of the step, in nanoseconds of the run.
    pub time_ns: i64,
    /// The new data that the cycle found: input ports, `Reference.operation` of ended calls and `Service.operation` of requests;
    /// empty if it was due by its time alone, or for events that had waited.
    pub cause: Vec<String>,
    /// The machines that began since the step before; empty if the step continues from the one before. There are several if a
    /// specification was replaced before it made a step.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub begins: Vec<MachineBegin>,
    /// Messages that reached the machine since the step before, in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub messages: Vec<RecordedMessage>,
    /// The bound locations whose value differs from that in the step before, by name; all of them at the beginning of a machine.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub frame: BTreeMap<String, String>,
    /// Monitored locations that the step read, with their values, in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub read: Vec<ReadLocation>,
    /// Choices of the step, in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub choices: Vec<ChoiceRecord>,
    /// The update set, ordered by location.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub updates: Vec<UpdateRecord>,
    /// Elements that the step added to domains, as `Domain: element`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub extended: Vec<String>,
    /// Messages that the step sent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sent: Vec<String>,
    /// The reason that the step failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fault: Option<String>,
    /// The properties that the step violated, or would have violated without the safe rule.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub violations: Vec<ViolationRecord>,
    /// The step of the main rule that the safe rule replaced. `choices` and `updates` are those of the safe rule.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub replaced: Option<ReplacedStep>,
}

/// A step that the safe rule replaced.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ReplacedStep {
    /// The safe rule.
    pub rule: String,
    /// Choices of the replaced step, which come before those of the safe rule.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub choices: Vec<ChoiceRecord>,
    /// The discarded update set; empty if the inputs alone violated a property, so that the main rule was not executed.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub updates: Vec<UpdateRecord>,
}

/// A location that a step read.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReadLocation {
    /// The location as text.
    pub location: String,
    /// Its value in the step.
    pub value: String,
}

/// A choice of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ChoiceRecord {
    /// Index of the chosen candidate, from 0.
    pub index: u64,
    /// Number of candidates.
    pub of: u64,
}

/// The beginning of a machine in a coordinator.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MachineBegin {
    /// The origin of its state.
    pub from: MachineOrigin,
    /// Elements that stand for services outside, for [`Machine::set_partners`].
    pub agents: Vec<String>,
    /// The specification and its imports, without the standard libraries; the first one is the specification.
    pub sources: Vec<SourceRecord>,
    /// Every location with a value before the step.
    pub state: BTreeMap<String, String>,
    /// The watched properties, and the safe rule.
    #[serde(default, skip_serializing_if = "is_default")]
    pub watch: Watch,
}

fn is_default(watch: &Watch) -> bool {
    *watch == Watch::default()
}

/// The origin of the state in which a machine begins.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum MachineOrigin {
    /// The initial state of the specification.
    #[default]
    Initial,
    /// The state of the machine before it, whose specification was replaced while it ran.
    Predecessor {
        /// Time of the replacement, in nanoseconds of the run.
        time_ns: i64,
        /// The inputs at this time, on which new initial values may depend.
        frame: BTreeMap<String, String>,
    },
    /// A frozen state, which is not part of the recording.
    Frozen,
}

/// A source text of a specification.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SourceRecord {
    /// Path of the file.
    pub path: String,
    /// The text; a recording stores it once, as an attachment.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub text: String,
    /// Hash of the text, which names the attachment.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub hash: String,
}

/// The parts of a recorded cycle that the step does not determine.
#[derive(Clone, Debug, Default)]
pub struct CycleCauses {
    /// See [`RecordedCycle::cause`].
    pub cause: Vec<String>,
    /// See [`RecordedCycle::begins`].
    pub begins: Vec<MachineBegin>,
    /// See [`RecordedCycle::messages`].
    pub messages: Vec<RecordedMessage>,
    /// See [`RecordedCycle::frame`].
    pub frame: BTreeMap<String, String>,
}

impl RecordedCycle {
    /// The record of the last step of a machine that had made `steps` steps before. `fault` is the message of the fault of a step
    /// that failed.
    pub fn of(
        specification: &Specification,
        machine: &Machine,
        steps: u64,
        causes: CycleCauses,
        fault: Option<String>,
    ) -> Self {
        let step = machine.last_step();
        let naming = machine.naming();
        let show = |value: &Value| value.show(&naming).to_string();
        let inputs = step.inputs().iter().map(|input| ReadLocation {
            location: simulate::location(machine, input.slot),
            value: show(&input.value),
        });
        let choices = step.choices().iter().map(|choice| ChoiceRecord {
            index: choice.index as u64,
            of: choice.count as u64,
        });
        let mut record = Self {
            specification: specification.model.name.to_string(),
            number: steps + 1,
            time_ns: step.now_ns(),
            cause: causes.cause,
            begins: causes.begins,
            messages: causes.messages,
            frame: causes.frame,
            read: inputs.collect(),
            choices: choices.collect(),
            updates: Vec::new(),
            extended: Vec::new(),
            sent: Vec::new(),
            fault,
            violations: Vec::new(),
            replaced: None,
        };
        // a step that breaks an invariant has a next state, and fails all the same
        if machine.steps() > steps {
            record.add_effects(specification, machine, &step);
        }
        record
    }

    fn add_effects(&mut self, specification: &Specification, machine: &Machine, step: &Step<'_>) {
        self.updates = update_records(specification, machine, step);
        let domains = &machine.program().symbols.domains;
        let extended = step.extended().iter().map(|(domain, atom)| {
            let domain = domains.get(domain.0 as usize).map_or("", |name| &**name);
            let element = Value::Atom(*atom);
            format!("{domain}: {}", element.show(&machine.naming()))
        });
        self.extended = extended.collect();
        let sent = step.sent().iter();
        self.sent = sent.map(|sent| simulate::sent(machine, sent)).collect();
    }
}
