//! The step of a coordinator whose properties are watched, and the safe rule.
//!
//! A step that violates a property is known before anything leaves the coordinator. With a safe rule, its update set is then
//! discarded: the machine goes back to the state before the step, and makes the step with the safe rule instead, with the same
//! inputs. Without a safe rule, the violation is reported only; a violated invariant makes the component fail in both cases if
//! nothing prevents it.

use crate::coordinator::Coordinator;
use crate::recorded::{ChoiceRecord, ReplacedStep};
use crate::step::update_records;
use crate::violation::{VIOLATION_REPORT, ViolationReaction, ViolationRecord};
use crate::watcher::{StepFailure, StepUndo, WatchedStep, word};
use asmotion_component::{Cycle, Fault, Time};
use asmotion_datum::Datum;
use asmotion_lang::FaultKind;
use asmotion_lang::ir::FunctionId;
use asmotion_verify::{PropertyKind, PropertyViolation};

impl Coordinator {
    /// Makes a step with the inputs of the frame, and watches it.
    pub(crate) fn watched_step(&mut self, now: Time) -> WatchedStep {
        let changed = self.frame.take_changed();
        let is_changed = |function: FunctionId| changed.contains(&function);
        let (machine, frame) = (&mut self.machine, &mut self.frame);
        let monitors = &mut self.watcher.monitors;
        let found = monitors.before_step(machine, frame, now.nanos(), &is_changed);
        let mut made = WatchedStep::default();
        self.note(&found, &mut made);
        let has_safe_rule = self.watcher.safe_rule.is_some();
        if found.is_empty() || !has_safe_rule {
            let undo = has_safe_rule.then(|| StepUndo::before(&self.machine));
            self.main_step(now, &mut made);
            if made.violations.is_empty() || made.is_over() {
                self.end_watch(&mut made);
                return made;
            }
            if let Some(undo) = undo {
                self.undo(undo, &mut made);
            }
        }
        if has_safe_rule {
            self.safe_step(now, &mut made);
        }
        self.end_watch(&mut made);
        made
    }

    /// Makes a step with the main rule, and notes what it violates.
    fn main_step(&mut self, now: Time, made: &mut WatchedStep) {
        let (machine, frame) = (&mut self.machine, &mut self.frame);
        let stepped = machine.step(frame, &mut self.chooser, now.nanos());
        match stepped.map(|_| ()) {
            Ok(()) => {
                self.watcher.violated_invariants.clear();
                let (machine, monitors) = (&mut self.machine, &mut self.watcher.monitors);
                let found = monitors.after_step(machine, now.nanos());
                self.note(&found, made);
            }
            Err(fault) => {
                if let FaultKind::Invariant { index, .. } = &fault.kind {
                    let record = self.invariant_record(*index);
                    made.violations.push(record);
                    self.watcher.violated_invariants.insert(*index);
                }
                made.failure = Some(StepFailure::Fault(fault));
            }
        }
    }

    fn invariant_record(&self, index: usize) -> ViolationRecord {
        let Some(invariant) = self.machine.program().invariants.get(index) else {
            return ViolationRecord::default();
        };
        let sources = &self.specification.sources;
        let span = self.specification.span(invariant.origin);
        let text: Vec<&str> = sources.snippet(span).split_whitespace().collect();
        let text = text.join(" ");
        let kind = if invariant.is_constraint {
            PropertyKind::Constraint
        } else {
            PropertyKind::Invariant
        };
        ViolationRecord {
            specification: self.specification.model.name.to_string(),
            kind: word(kind).to_owned(),
            name: (*invariant.name != *text).then(|| invariant.name.to_string()),
            property: text,
            place: self.specification.place(invariant.origin),
            is_repeated: self.watcher.violated_invariants.contains(&index),
            ..ViolationRecord::default()
        }
    }

    fn note(&self, found: &[PropertyViolation], made: &mut WatchedStep) {
        for violation in found {
            let record = self.watcher.record(&self.specification, violation);
            // both halves of a position can violate a property in one step
            let is_known = made.violations.iter().any(|it| {
                (&it.kind, &it.property, &it.place)
                    == (&record.kind, &record.property, &record.place)
            });
            if !is_known {
                made.violations.push(record);
            }
        }
    }

    /// Goes back to the state before the step.
    fn undo(&mut self, undo: StepUndo, made: &mut WatchedStep) {
        let step = self.machine.last_step();
        let choices = step.choices().iter().map(|choice| ChoiceRecord {
            index: choice.index as u64,
            of: choice.count as u64,
        });
        made.replaced = Some(ReplacedStep {
            rule: String::new(),
            choices: choices.collect(),
            updates: update_records(&self.specification, &self.machine, &step),
        });
        made.failure = None;
        self.watcher.monitors.undo_step(&self.machine);
        undo.apply(&mut self.machine);
    }

    /// Makes the step with the safe rule.
    fn safe_step(&mut self, now: Time, made: &mut WatchedStep) {
        let Some(safe) = &self.watcher.safe_rule else {
            return;
        };
        made.replaced
            .get_or_insert_default()
            .rule
            .clone_from(&safe.text);
        let (machine, frame) = (&mut self.machine, &mut self.frame);
        let stepped = machine.step_with(safe.rule, frame, &mut self.chooser, now.nanos());
        if let Err(fault) = stepped.map(|_| ()) {
            made.failure = Some(StepFailure::Fault(fault));
            return;
        }
        let monitors = &mut self.watcher.monitors;
        let found = monitors.after_step(&mut self.machine, now.nanos());
        // what is late stays late: the rule is the reaction to it
        let violated = found.iter().filter(|it| !it.is_late);
        let texts: Vec<String> = violated
            .filter_map(|it| self.watcher.monitors.watched().get(it.property))
            .map(|it| it.text.clone())
            .collect();
        if !texts.is_empty() {
            made.failure = Some(StepFailure::Unsafe(texts));
        }
    }

    fn end_watch(&mut self, made: &mut WatchedStep) {
        self.watcher.monitors.end_step();
        let reaction = match (&made.failure, &made.replaced) {
            (Some(_), _) => ViolationReaction::Failed,
            (None, Some(_)) => ViolationReaction::SafeRule,
            (None, None) => ViolationReaction::Reported,
        };
        let number = self.machine.steps();
        for violation in &mut made.violations {
            (violation.step, violation.reaction) = (number, reaction);
        }
    }

    /// Reports the violations of a step that are new.
    pub(crate) fn report_violations(
        violations: &[ViolationRecord],
        cycle: &mut Cycle<'_>,
    ) -> Result<(), Fault> {
        for violation in violations.iter().filter(|it| !it.is_repeated) {
            cycle.report(VIOLATION_REPORT, Datum::of(violation)?);
        }
        Ok(())
    }
}
