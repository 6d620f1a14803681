//! Recordings of runs (`asmotion run --record FILE`).
//!
//! **As a table** (CSV): the values that ports published. The first column, `time_s`, has the time in seconds with nine decimals.
//! Every other column has one scalar part of the samples of a port: `Driver.status.joints.0.position` is the field `position` of
//! the first element of the field `joints` of a sample of the port `status` of `Driver`. A row has the values of one instant; a
//! port that published several samples at an instant has several rows. Of lists with more than 64 elements only the length is
//! recorded, in a column that ends in `.count`.
//!
//! **As MCAP** (feature `mcap`): messages, calls, events, and every step of every coordinator with what it takes to repeat it. See
//! `RunRecorder`; `CoordinatorReplay` repeats these steps.

mod pattern;
mod profile;
mod read;
#[cfg(feature = "mcap")]
mod replay;
#[cfg(feature = "mcap")]
mod run;
mod write;

pub use profile::RecordingProfile;
pub use read::{RecordingError, read_samples};
#[cfg(feature = "mcap")]
pub use replay::{
    CoordinatorReplay, DifferenceKind, EditedSpecification, InputChange, LocationWriter,
    RecordedMachine, RecordedMachines, ReplayCounts, ReplayFailure, ReplayOptions, RunFiles,
    RunItems, SourceTexts, StepDifference, WrittenValue,
};
#[cfg(feature = "mcap")]
pub use run::{
    ChainedCycle, CoordinatorEnd, FileEnd, MessageData, Overflow, RecorderOptions, RecordingEnd,
    RecordingFailure, RecordingFile, RecordingItem, RunReader, RunRecorder, StepChain, StepHashes,
    part_path,
};
pub use write::PortRecording;
