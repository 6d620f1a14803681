//! Violations of properties, for observers.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Kind of the report about a property that a step violates, a [`ViolationRecord`]. A property that is violated in several
/// successive steps is reported once.
pub const VIOLATION_REPORT: &str = "asm/Violation";

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
    #[serde(skip_serializing_if = "std::ops::Not::not")]
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
        let shown = |text: &str, holds: bool| {
            let not = if holds { "" } else { "not " };
            format!("{not}`{text}`")
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
