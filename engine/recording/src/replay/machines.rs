//! The machines of recorded coordinators, each with its steps, for a session that goes back and forth.

use std::collections::BTreeMap;

use asmotion_coordinator::{MachineBegin, RecordedCycle};
use asmotion_lang::Specification;
use asmotion_lang::simulate::{RecordedMessage, RecordedStep};

use super::failure::ReplayFailure;
use super::files::RunFiles;
use super::inputs::RecordedFrame;
use super::sources::SourceTexts;
use crate::read::RecordingError;
use crate::run::RecordingItem;

/// The machines of all coordinators of a recording, in the order of their beginnings.
#[derive(Default)]
pub struct RecordedMachines {
    /// By name of the coordinator.
    pub machines: BTreeMap<String, Vec<RecordedMachine>>,
    texts: SourceTexts,
    frames: BTreeMap<String, RecordedFrame>,
}

/// A machine of a coordinator, from its beginning to the next one.
pub struct RecordedMachine {
    /// Its beginning.
    pub begin: MachineBegin,
    /// Time of its first step in the run.
    pub time_ns: i64,
    /// Its steps, up to the first one that the safe rule made. One that failed is among them only if it is the last.
    pub steps: Vec<RecordedStep>,
    /// Number of the first step that the safe rule made, and the rule.
    pub safe_step: Option<(u64, String)>,
    /// Number of the last step, and the messages before it.
    last: (u64, Vec<RecordedMessage>),
}

impl RecordedMachines {
    /// Reads a recording. Steps after missing ones are left out.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn read(files: &RunFiles) -> Result<Self, RecordingError> {
        let mut read = Self::default();
        let mut hashes: BTreeMap<String, String> = BTreeMap::new();
        for item in files.items()? {
            match item {
                RecordingItem::Text { name, text, .. } => read.texts.add(&name, text),
                RecordingItem::Step { component, step } => {
                    let before = hashes.get(&component);
                    let is_next = before.is_none_or(|hash| *hash == step.hashes.previous);
                    if is_next || !step.cycle.begins.is_empty() {
                        hashes.insert(component.clone(), step.hashes.hash.clone());
                        read.add(component, &step.cycle);
                    }
                }
                RecordingItem::Message { .. } | RecordingItem::End(_) | RecordingItem::Cut(_) => {}
            }
        }
        Ok(read)
    }

    fn add(&mut self, component: String, cycle: &RecordedCycle) {
        let frame = self.frames.entry(component.clone()).or_default();
        frame.advance(cycle);
        let machines = self.machines.entry(component).or_default();
        if let Some(begin) = cycle.begins.last() {
            machines.push(RecordedMachine {
                begin: begin.clone(),
                time_ns: cycle.time_ns,
                steps: Vec::new(),
                safe_step: None,
                last: (0, Vec::new()),
            });
        }
        if let Some(machine) = machines.last_mut() {
            machine.add(cycle, frame);
        }
    }

    /// Opens the specification of a machine.
    ///
    /// # Errors
    /// Its texts are not attached, or have errors.
    pub fn specification(&self, machine: &RecordedMachine) -> Result<Specification, ReplayFailure> {
        self.texts.open(&machine.begin)
    }
}

impl RecordedMachine {
    fn add(&mut self, cycle: &RecordedCycle, frame: &RecordedFrame) {
        if let Some(replaced) = &cycle.replaced {
            let rule = || (cycle.number, replaced.rule.clone());
            self.safe_step.get_or_insert_with(rule);
        }
        if self.safe_step.is_some() {
            return;
        }
        let (number, mut messages) = std::mem::take(&mut self.last);
        if number == cycle.number {
            // the step before has failed: this one takes its number, and finds its messages
            self.steps.pop();
        } else {
            messages.clear();
        }
        messages.extend(cycle.messages.iter().cloned());
        self.last = (cycle.number, messages.clone());
        let cycle = RecordedCycle {
            messages,
            ..cycle.clone()
        };
        self.steps.push(frame.step(&cycle));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_takes_the_place_of_one_that_failed() {
        let cycle = |number, fault: Option<&str>| RecordedCycle {
            number,
            fault: fault.map(str::to_owned),
            messages: match fault {
                Some(_) => vec![RecordedMessage::Channel { is_down: true }],
                None => Vec::new(),
            },
            ..RecordedCycle::default()
        };
        let mut read = RecordedMachines::default();
        let first = RecordedCycle {
            begins: vec![MachineBegin::default()],
            ..cycle(1, Some("an input was undef"))
        };
        for cycle in [
            first,
            cycle(1, None),
            cycle(2, None),
            cycle(3, Some("clash")),
        ] {
            read.add("A".to_owned(), &cycle);
        }
        let [machine] = read.machines["A"].as_slice() else {
            panic!("one machine has begun");
        };
        let messages = machine.steps.iter().map(RecordedStep::has_messages);
        // the first step finds the message that reached the machine before the failed one
        assert_eq!(messages.collect::<Vec<_>>(), [true, false, true]);
    }
}
