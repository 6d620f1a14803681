//! Runs as MCAP files, which standard readers open.
//!
//! ```text
//! executor ─events→ RunRecorder ─jobs→ queue ─→ writer thread → file
//!           (observer: JSON, hashes)  bounded    chunks, flushed twice a second
//! ```
//!
//! The recorder is an observer, so it runs in no cycle: in a live run its thread is the one that owns the run. It never waits
//! there; what does not fit into the queue is counted. In simulated time it waits instead, because no clock runs meanwhile.

mod chain;
mod channels;
mod event_record;
mod file;
mod message_data;
mod options;
mod queue;
mod reader;
mod recorder;
mod schemas;
mod writer;

pub use chain::{StepChain, StepHashes};
pub use message_data::MessageData;
pub use options::{Overflow, RecorderOptions, RecordingFile, part_path};
pub use reader::{ChainedCycle, CoordinatorEnd, FileEnd, RecordingItem, RunReader};
pub use recorder::RunRecorder;
pub use writer::{RecordingEnd, RecordingFailure};
