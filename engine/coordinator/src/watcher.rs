//! Watches the properties of a specification.

use crate::bind_error::BindError;
use crate::recorded::ReplacedStep;
use crate::violation::{ConditionRecord, ViolationRecord};
use crate::watch::Watch;
use asmotion_lang::ir::AddedRule;
use asmotion_lang::machine::{Machine, StepFault};
use asmotion_lang::{FaultKind, Specification};
use asmotion_verify::{Monitors, PropertyKind, PropertyViolation};
use std::collections::BTreeSet;

/// Watches the properties of a specification.
#[derive(Clone)]
pub struct Watcher {
    pub(crate) watch: Watch,
    pub(crate) monitors: Monitors,
    pub(crate) safe_rule: Option<SafeRule>,
    /// Invariants that were violated in the last step.
    pub(crate) violated_invariants: BTreeSet<usize>,
}

#[derive(Clone)]
pub(crate) struct SafeRule {
    pub text: String,
    pub rule: AddedRule,
}

/// A step that was made or failed, with what it violated.
#[derive(Debug, Default)]
pub struct WatchedStep {
    /// The reason that the step failed; `None` if it was made.
    pub failure: Option<StepFailure>,
    /// The properties that the step violated, or would have violated without the safe rule.
    pub violations: Vec<ViolationRecord>,
    /// The step that the safe rule replaced.
    pub replaced: Option<ReplacedStep>,
}

/// The reason for which a step failed.
#[derive(Debug)]
pub enum StepFailure {
    /// A fault of the machine.
    Fault(Box<StepFault>),
    /// The step of the safe rule violates these properties, too.
    Unsafe(Vec<String>),
}

impl StepFailure {
    /// Message of the failure of a machine.
    pub fn message(&self, specification: &Specification, machine: &Machine) -> String {
        match self {
            Self::Fault(fault) => specification.explain_in(fault, machine).message,
            Self::Unsafe(properties) => {
                let properties = properties.join("`, `");
                format!("the step of the safe rule violates `{properties}`, too")
            }
        }
    }
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
            watch: watch.clone(),
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

    /// Continues with the properties that the watcher of a predecessor has, too. Returns those that only the predecessor has.
    pub fn continue_from(&mut self, predecessor: &Self) -> Vec<String> {
        self.monitors.continue_from(&predecessor.monitors)
    }

    /// The rule that replaces the main rule in a step that violates a property.
    pub fn safe_rule(&self) -> Option<AddedRule> {
        self.safe_rule.as_ref().map(|it| it.rule)
    }

    pub(crate) fn record(
        &self,
        specification: &Specification,
        found: &PropertyViolation,
    ) -> ViolationRecord {
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

impl WatchedStep {
    /// Returns `true` if the step failed for another reason than an invariant, so that there is nothing to replace.
    pub(crate) fn is_over(&self) -> bool {
        let Some(StepFailure::Fault(fault)) = &self.failure else {
            return false;
        };
        !matches!(fault.kind, FaultKind::Invariant { .. })
    }
}

/// The way back from a step.
pub(crate) enum StepUndo {
    /// The machine reverts its last step.
    Revert,
    /// A copy of the machine before the step.
    Copy(Box<Machine>),
}

impl StepUndo {
    pub fn before(machine: &Machine) -> Self {
        if machine.can_revert() {
            Self::Revert
        } else {
            Self::Copy(Box::new(machine.clone()))
        }
    }

    pub fn apply(self, machine: &mut Machine) {
        match self {
            Self::Revert => machine.revert(),
            Self::Copy(copy) => *machine = *copy,
        }
    }
}
