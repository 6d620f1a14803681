//! The first difference between a recorded step and its repetition.

use asmotion_coordinator::{ChoiceRecord, ReadLocation};
use asmotion_lang::guards::PassedGuard;

/// The first step in which a replay differs from its recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StepDifference {
    /// Number of the step.
    pub number: u64,
    /// Time of the step in the run.
    pub time_ns: i64,
    /// Cause of the step: see [`RecordedCycle::cause`](asmotion_coordinator::RecordedCycle::cause).
    pub cause: Vec<String>,
    /// The record is not the one that the run wrote: its hash is not that of its content.
    pub is_altered: bool,
    /// The first difference in the step.
    pub kind: DifferenceKind,
    /// The guards on the way to the update of an edited specification, outermost first.
    pub guards: Vec<PassedGuard>,
}

/// The first difference in a step. `None` stands for what exists on one side only.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DifferenceKind {
    /// The content of the record was changed, and the part that was changed is none that a repetition computes.
    Altered,
    /// Inputs or messages of the record do not fit the specification.
    Unfit {
        /// The recorded texts.
        texts: Vec<String>,
    },
    /// The number of the step.
    Number {
        /// Number in the repetition.
        replayed: u64,
    },
    /// A location in the state in which the machine began.
    Begin {
        /// The location.
        location: String,
        /// Recorded value.
        recorded: String,
        /// Value in the repetition.
        replayed: String,
    },
    /// An update.
    Update {
        /// The updated location.
        location: String,
        /// Recorded update.
        recorded: Option<WrittenValue>,
        /// Update of the repetition.
        replayed: Option<WrittenValue>,
    },
    /// The step fails on one side only, or for another reason.
    Fault {
        /// Recorded reason.
        recorded: Option<String>,
        /// Reason in the repetition.
        replayed: Option<String>,
    },
    /// Another rule made the step: `None` is the main rule.
    Rule {
        /// The safe rule of the recorded step.
        recorded: Option<String>,
        /// The safe rule of the repetition.
        replayed: Option<String>,
    },
    /// A property that the step violates.
    Violation {
        /// The recorded violation.
        recorded: Option<String>,
        /// Violation in the repetition.
        replayed: Option<String>,
    },
    /// An element added to a domain.
    Extended {
        /// Recorded element.
        recorded: Option<String>,
        /// Element in the repetition.
        replayed: Option<String>,
    },
    /// A message sent by the step.
    Sent {
        /// Recorded message.
        recorded: Option<String>,
        /// Message of the repetition.
        replayed: Option<String>,
    },
    /// An input that the step read.
    Read {
        /// Recorded input.
        recorded: Option<ReadLocation>,
        /// Input in the repetition.
        replayed: Option<ReadLocation>,
    },
    /// A choice.
    Choice {
        /// Recorded choice.
        recorded: Option<ChoiceRecord>,
        /// Choice in the repetition.
        replayed: Option<ChoiceRecord>,
    },
    /// The last steps are missing, and the recording counts none as lost.
    Missing,
}

/// An update of a location, with its origin.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WrittenValue {
    /// Value before the step.
    pub before: String,
    /// Value after the step.
    pub after: String,
    /// Place of the update rule, as in `navigate.asm:42`.
    pub place: String,
    /// Name of the rule declaration that contains it, if it is known.
    pub rule: Option<String>,
}
