//! Properties watched while a coordinator runs, and the safe rule.
//!
//! A step that violates a property is known before anything leaves the coordinator. With a safe rule, its update set is then
//! discarded: the machine goes back to the state before the step, and makes the step with the safe rule instead, with the same
//! inputs. Without a safe rule, the violation is reported only; a violated invariant makes the component fail in both cases if
//! nothing prevents it.

use crate::bind_error::BindError;
use crate::coordinator::Coordinator;
use crate::recorded::{ChoiceRecord, ReplacedStep};
use crate::step::update_records;
use asmotion_component::{Cycle, Fault, Time};
use asmotion_datum::Datum;
use asmotion_lang::ir::{AddedRule, FunctionId};
use asmotion_lang::machine::{Machine, StepFault};
use asmotion_lang::{FaultKind, Specification};
use asmotion_verify::{Monitors, PropertyKind, PropertyViolation};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fmt;

pub use asmotion_verify::GivenProperty;

/// Kind of the report about a property that a step violates, a [`ViolationRecord`]. A property that is violated in several
/// successive steps is reported once.
pub const VIOLATION_REPORT: &str = "asm/Violation";

/// The properties to watch, and the reaction to violations.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Watch {
    /// Temporal properties are not watched. Invariants are always checked.
    pub is_off: bool,
    /// A rule in the scope of the specification, as in `r_halt[IDLE]`, that replaces the main rule in a step that violates a
    /// property.
    pub safe_rule: Option<String>,
    /// Properties in addition to those of the specification.
    pub properties: Vec<GivenProperty>,
}

/// A violation of a property, for observers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ViolationRecord {
    /// Name of the specification.
    pub specification: String,
    /// Number of the step.
    pub step: u64,
    /// `invariant`, `INVAR`, `CTLSPEC` or `LTLSPEC`.
    pub kind: String,
    /// Declared name of the property.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Text of the property.
    pub property: String,
    /// File name and line; empty for a property that the composite states.
    pub place: String,
    /// The time within which something should have happened, if that is what is violated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub late_after_s: Option<f64>,
    /// Conditions of the property, with their values before and after the step.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub conditions: Vec<ConditionRecord>,
    /// The property was violated in the step before, too.
    #[serde(skip_serializing_if = "is_false")]
    pub is_repeated: bool,
    /// Reaction to the violation.
    pub reaction: ViolationReaction,
}

/// A condition of a violated property.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct ConditionRecord {
    /// Text of the condition.
    pub text: String,
    /// Its value before the step, with the inputs of the step.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub before: Option<bool>,
    /// Its value after the step, if it does not depend on the inputs of the next one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub after: Option<bool>,
}

/// The reaction to a violation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ViolationReaction {
    /// It is reported, and the run goes on.
    #[default]
    Reported,
    /// The safe rule made the step.
    SafeRule,
    /// The component failed.
    Failed,
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "the signature that serde calls"
)]
fn is_false(value: &bool) -> bool {
    !value
}

impl fmt::Display for ViolationRecord {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "step {} violates {} ", self.step, self.kind)?;
        if let Some(name) = &self.name {
            write!(to, "{name}: ")?;
        }
        write!(to, "`{}`", self.property)?;
        if !self.place.is_empty() {
            write!(to, " ({})", self.place)?;
        }
        if let Some(seconds) = self.late_after_s {
            write!(to, ", which has not happened within {seconds} s")?;
        }
        let shown = |text: &str, holds: bool| match holds {
            true => format!("`{text}`"),
            false => format!("not `{text}`"),
        };
        let mut separator = ": ";
        for condition in &self.conditions {
            let (text, before, after) = (&condition.text, condition.before, condition.after);
            let text = match (before, after) {
                (Some(before), Some(after)) if before != after => {
                    format!("{}, then {}", shown(text, before), shown(text, after))
                }
                (_, Some(value)) | (Some(value), None) => shown(text, value),
                (None, None) => continue,
            };
            write!(to, "{separator}{text}")?;
            separator = "; ";
        }
        match self.reaction {
            ViolationReaction::Reported => Ok(()),
            ViolationReaction::SafeRule => to.write_str("; the safe rule makes the step"),
            ViolationReaction::Failed => to.write_str("; the component fails"),
        }
    }
}

/// Watches the properties of a specification.
pub(crate) struct Watcher {
    pub monitors: Monitors,
    safe_rule: Option<SafeRule>,
    /// Invariants that were violated in the last step.
    violated_invariants: BTreeSet<usize>,
}

struct SafeRule {
    text: String,
    rule: AddedRule,
}

/// A step that was made or failed, with what it violated.
#[derive(Default)]
pub(crate) struct WatchedStep {
    pub failure: Option<StepFailure>,
    pub violations: Vec<ViolationRecord>,
    /// The step that the safe rule replaced.
    pub replaced: Option<ReplacedStep>,
}

/// The reason for which a step failed.
pub(crate) enum StepFailure {
    Fault(Box<StepFault>),
    /// The step of the safe rule violates these properties, too.
    Unsafe(Vec<String>),
}

impl Watcher {
    /// Adds the properties and the safe rule to a specification.
    ///
    /// # Errors
    /// One of them does not fit the specification.
    pub fn new(specification: &mut Specification, watch: &Watch) -> Result<Self, BindError> {
        let safe_rule = match &watch.safe_rule {
            Some(text) => Some(SafeRule {
                rule: add_rule(specification, text)?,
                text: text.clone(),
            }),
            None => None,
        };
        let monitors = if watch.is_off {
            Ok(Monitors::default())
        } else {
            Monitors::of(specification, &watch.properties)
        };
        let monitors = monitors.map_err(|report| BindError::InvalidProperty {
            reason: first_message(&report),
        })?;
        // those of the specification may be there for its verification
        if let Some(given) = monitors.unwatched().iter().find(|it| it.at.is_none()) {
            return Err(BindError::InvalidProperty {
                reason: format!("a run cannot watch `{}`: {}", given.text, given.reason),
            });
        }
        Ok(Self {
            monitors,
            safe_rule,
            violated_invariants: BTreeSet::new(),
        })
    }

    /// Begins again, with a machine in its initial state.
    pub fn begin(&mut self) {
        self.monitors.begin();
        self.violated_invariants.clear();
    }

    fn record(&self, specification: &Specification, found: &PropertyViolation) -> ViolationRecord {
        let Some(property) = self.monitors.watched().get(found.property) else {
            return ViolationRecord::default();
        };
        let late = property.within_ns.filter(|_| found.is_late);
        let conditions = found.conditions.iter().map(|condition| ConditionRecord {
            text: condition.text.clone(),
            before: condition.before,
            after: condition.after,
        });
        ViolationRecord {
            specification: specification.model.name.to_string(),
            kind: word(property.kind).to_owned(),
            name: property.name.clone(),
            property: property.text.clone(),
            place: property.place.clone(),
            late_after_s: late.map(|ns| ns as f64 / 1e9),
            conditions: conditions.collect(),
            is_repeated: !found.is_new,
            ..ViolationRecord::default()
        }
    }
}

/// Adds a rule to a specification.
fn add_rule(specification: &mut Specification, text: &str) -> Result<AddedRule, BindError> {
    let invalid = |report: &asmotion_lang::Report| BindError::InvalidRule {
        rule: text.to_owned(),
        reason: first_message(report),
    };
    let file = specification.sources.add("<safe rule>", text);
    let rule = asmotion_lang::syntax::parse_rule(file, text).map_err(|report| invalid(&report))?;
    let added = specification.model.add_rule(&rule);
    let added = added.map_err(|report| invalid(&report))?;
    specification.lower().map_err(|report| invalid(&report))?;
    Ok(added)
}

fn first_message(report: &asmotion_lang::Report) -> String {
    let first = report.diagnostics.first();
    first.map(|it| it.message.clone()).unwrap_or_default()
}

/// The keyword of a property.
pub(crate) fn word(kind: PropertyKind) -> &'static str {
    match kind {
        PropertyKind::Ctl => "CTLSPEC",
        PropertyKind::Ltl => "LTLSPEC",
        PropertyKind::Constraint => "INVAR",
        PropertyKind::Invariant
        | PropertyKind::Possible
        | PropertyKind::NoFault
        | PropertyKind::NotStuck
        | PropertyKind::RulesRun => "invariant",
    }
}

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

impl WatchedStep {
    /// Returns `true` if the step failed for another reason than an invariant, so that there is nothing to replace.
    fn is_over(&self) -> bool {
        let Some(StepFailure::Fault(fault)) = &self.failure else {
            return false;
        };
        !matches!(fault.kind, FaultKind::Invariant { .. })
    }
}

/// The way back from a step.
enum StepUndo {
    /// The machine reverts its last step.
    Revert,
    /// A copy of the machine before the step.
    Copy(Box<Machine>),
}

impl StepUndo {
    fn before(machine: &Machine) -> Self {
        if machine.can_revert() {
            Self::Revert
        } else {
            Self::Copy(Box::new(machine.clone()))
        }
    }

    fn apply(self, machine: &mut Machine) {
        match self {
            Self::Revert => machine.revert(),
            Self::Copy(copy) => *machine = *copy,
        }
    }
}
