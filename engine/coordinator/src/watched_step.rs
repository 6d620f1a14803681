//! The step of a machine whose properties are watched, and the safe rule.
//!
//! A step that violates a property is known before anything leaves the coordinator. With a safe rule, its update set is then
//! discarded: the machine goes back to the state before the step, and makes the step with the safe rule instead, with the same
//! inputs. Without a safe rule, the violation is reported only; a violated invariant makes the component fail in both cases if
//! nothing prevents it.

use crate::coordinator::Coordinator;
use crate::recorded::{ChoiceRecord, ReplacedStep};
use crate::step::update_records;
use crate::violation::{VIOLATION_REPORT, ViolationReaction, ViolationRecord};
use crate::watcher::{StepFailure, StepUndo, WatchedStep, Watcher, word};
use asmotion_component::{Cycle, Fault, Time};
use asmotion_datum::Datum;
use asmotion_lang::ir::FunctionId;
use asmotion_lang::machine::{Chooser, Environment, Machine};
use asmotion_lang::{FaultKind, Specification};
use asmotion_verify::{PropertyKind, PropertyViolation};

/// A machine that is about to make a step, with what the step depends on.
pub struct StepSubject<'a> {
    /// The specification of the machine.
    pub specification: &'a Specification,
    /// The machine, in the state before the step.
    pub machine: &'a mut Machine,
    /// The inputs of the step.
    pub inputs: &'a mut dyn Environment,
    /// Makes the choices of the step.
    pub chooser: &'a mut dyn Chooser,
    /// Time of the step, in nanoseconds.
    pub now_ns: i64,
}

impl Watcher {
    /// Makes a step, and watches it. `is_changed` says which inputs may have other values than in the step before.
    pub fn step(
        &mut self,
        mut of: StepSubject<'_>,
        is_changed: &dyn Fn(FunctionId) -> bool,
    ) -> WatchedStep {
        let found = self
            .monitors
            .before_step(of.machine, of.inputs, of.now_ns, is_changed);
        let mut made = WatchedStep::default();
        self.note(&found, &of, &mut made);
        let has_safe_rule = self.safe_rule.is_some();
        if found.is_empty() || !has_safe_rule {
            let undo = has_safe_rule.then(|| StepUndo::before(of.machine));
            self.main_step(&mut of, &mut made);
            if made.violations.is_empty() || made.is_over() {
                self.end_step(&of, &mut made);
                return made;
            }
            if let Some(undo) = undo {
                self.undo(undo, &mut of, &mut made);
            }
        }
        if has_safe_rule {
            self.safe_step(&mut of, &mut made);
        }
        self.end_step(&of, &mut made);
        made
    }

    /// Makes a step with the main rule, and notes what it violates.
    fn main_step(&mut self, of: &mut StepSubject<'_>, made: &mut WatchedStep) {
        let stepped = of.machine.step(of.inputs, of.chooser, of.now_ns);
        match stepped.map(|_| ()) {
            Ok(()) => {
                self.violated_invariants.clear();
                let found = self.monitors.after_step(of.machine, of.now_ns);
                self.note(&found, of, made);
            }
            Err(fault) => {
                if let FaultKind::Invariant { index, .. } = &fault.kind {
                    made.violations.push(self.invariant_record(*index, of));
                    self.violated_invariants.insert(*index);
                }
                made.failure = Some(StepFailure::Fault(fault));
            }
        }
    }

    fn invariant_record(&self, index: usize, of: &StepSubject<'_>) -> ViolationRecord {
        let Some(invariant) = of.machine.program().invariants.get(index) else {
            return ViolationRecord::default();
        };
        let sources = &of.specification.sources;
        let span = of.specification.span(invariant.origin);
        let text: Vec<&str> = sources.snippet(span).split_whitespace().collect();
        let text = text.join(" ");
        let kind = if invariant.is_constraint {
            PropertyKind::Constraint
        } else {
            PropertyKind::Invariant
        };
        ViolationRecord {
            specification: of.specification.model.name.to_string(),
            kind: word(kind).to_owned(),
            name: (*invariant.name != *text).then(|| invariant.name.to_string()),
            property: text,
            place: of.specification.place(invariant.origin),
            is_repeated: self.violated_invariants.contains(&index),
            ..ViolationRecord::default()
        }
    }

    fn note(&self, found: &[PropertyViolation], of: &StepSubject<'_>, made: &mut WatchedStep) {
        for violation in found {
            let record = self.record(of.specification, violation);
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
    fn undo(&mut self, undo: StepUndo, of: &mut StepSubject<'_>, made: &mut WatchedStep) {
        let step = of.machine.last_step();
        let choices = step.choices().iter().map(|choice| ChoiceRecord {
            index: choice.index as u64,
            of: choice.count as u64,
        });
        made.replaced = Some(ReplacedStep {
            rule: String::new(),
            choices: choices.collect(),
            updates: update_records(of.specification, of.machine, &step),
        });
        made.failure = None;
        self.monitors.undo_step(of.machine);
        undo.apply(of.machine);
    }

    /// Makes the step with the safe rule.
    fn safe_step(&mut self, of: &mut StepSubject<'_>, made: &mut WatchedStep) {
        let Some(safe) = &self.safe_rule else {
            return;
        };
        made.replaced
            .get_or_insert_default()
            .rule
            .clone_from(&safe.text);
        let stepped = of
            .machine
            .step_with(safe.rule, of.inputs, of.chooser, of.now_ns);
        if let Err(fault) = stepped.map(|_| ()) {
            made.failure = Some(StepFailure::Fault(fault));
            return;
        }
        let found = self.monitors.after_step(of.machine, of.now_ns);
        // what is late stays late: the rule is the reaction to it
        let violated = found.iter().filter(|it| !it.is_late);
        let texts: Vec<String> = violated
            .filter_map(|it| self.monitors.watched().get(it.property))
            .map(|it| it.text.clone())
            .collect();
        if !texts.is_empty() {
            made.failure = Some(StepFailure::Unsafe(texts));
        }
    }

    fn end_step(&mut self, of: &StepSubject<'_>, made: &mut WatchedStep) {
        self.monitors.end_step();
        let reaction = match (&made.failure, &made.replaced) {
            (Some(_), _) => ViolationReaction::Failed,
            (None, Some(_)) => ViolationReaction::SafeRule,
            (None, None) => ViolationReaction::Reported,
        };
        let number = of.machine.steps();
        for violation in &mut made.violations {
            (violation.step, violation.reaction) = (number, reaction);
        }
    }
}

impl Coordinator {
    /// Makes a step with the inputs of the frame, and watches it.
    pub(crate) fn watched_step(&mut self, now: Time) -> WatchedStep {
        let changed = self.frame.take_changed();
        let subject = StepSubject {
            specification: &self.prepared.specification,
            machine: &mut self.machine,
            inputs: &mut self.frame,
            chooser: &mut self.chooser,
            now_ns: now.nanos(),
        };
        self.watcher
            .step(subject, &|function| changed.contains(&function))
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
