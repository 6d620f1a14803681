//! Repeats the steps of recorded coordinators on the recorded inputs and choices, and compares every record with what the
//! repetition does.
//!
//! ```text
//! files ─RunItems→ records ─CoordinatorReplay→ machine ─step→ record again ─compare→ equal, or the first StepDifference
//!                              └ begins: sources attached to the recording, or an edited specification
//! ```
//!
//! A step is repeated from its record alone: inputs, choices, messages and time. So a recording of a run in real time over a
//! broker is repeated like one in virtual time, and without any other process.

mod begin;
mod compare;
mod coordinator;
mod difference;
mod explanation;
mod failure;
mod files;
mod inputs;
mod machines;
mod sources;

pub use coordinator::{CoordinatorReplay, ReplayCounts, ReplayOptions};
pub use difference::{DifferenceKind, StepDifference, WrittenValue};
pub use explanation::{InputChange, LocationWriter};
pub use failure::ReplayFailure;
pub use files::{RunFiles, RunItems};
pub use machines::{RecordedMachine, RecordedMachines};
pub use sources::{EditedSpecification, SourceTexts};
