//! Files written by a run: the trace and the recording.

use std::fs::File;
use std::io;
use std::path::Path;

use asmotion_component::Time;
use asmotion_recording::{PortRecording, RecordingProfile};
use asmotion_runtime::Event;
use clap::{Args, ValueEnum};

use crate::mission::RecordingRequest;
use crate::trace::MissionTrace;

/// Options that select the files to write.
#[derive(Args, Clone, Default)]
pub struct OutputArguments {
    /// Writes a trace of the run, one event a line; equal runs give equal bytes
    #[arg(long, value_name = "FILE")]
    trace: Option<String>,

    /// Records the run. A name that ends in `.mcap` records messages, calls, events and the steps of coordinators, for viewers such
    /// as Foxglove; a file that exists is kept, and the new one gets a number. Any other name gets the values of ports as a table
    /// (CSV): a row for each instant, a column for each number, named `Component.port.field`
    #[arg(long, value_name = "FILE")]
    record: Option<String>,

    /// Readers of a recording in MCAP: viewers such as Foxglove, or tools for bags of ROS 2, such as `ros2 bag` and `rosbags`
    #[arg(long, value_name = "READERS", value_enum, requires = "record")]
    record_for: Option<RecordingReaders>,

    /// Ports or topics to record; `*` matches any characters [default: all]
    #[arg(long, value_name = "PATTERN", requires = "record")]
    ports: Vec<String>,
}

/// Readers of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum RecordingReaders {
    /// Foxglove, Lichtblick, PlotJuggler: types of ROS 2 in CDR, everything else in JSON with a JSON Schema
    Viewers,
    /// Tools for bags of ROS 2: everything in CDR, with names of topics of ROS
    Ros2,
}

/// The files being written.
#[derive(Debug, Default)]
pub struct OutputFiles {
    trace: Option<(String, MissionTrace)>,
    record: Option<(String, PortRecording)>,
}

impl OutputArguments {
    /// The requested recording as MCAP, and that of the composite.
    pub fn recording(&self, follows_composite: bool) -> RecordingRequest {
        RecordingRequest {
            file: self.record.clone().filter(|path| is_mcap(path)),
            ports: self.ports.clone(),
            profile: match self.record_for {
                None | Some(RecordingReaders::Viewers) => RecordingProfile::Viewers,
                Some(RecordingReaders::Ros2) => RecordingProfile::Ros2,
            },
            follows_composite,
        }
    }

    /// Checks that each option has an effect.
    ///
    /// # Errors
    /// The readers of a table are named.
    pub fn check(&self) -> Result<(), String> {
        match (&self.record, self.record_for) {
            (Some(path), Some(_)) if !is_mcap(path) => Err(format!(
                "`--record-for` has no effect on a table: record to a file whose name ends in `.mcap`, not to `{path}`"
            )),
            (Some(_) | None, Some(_) | None) => Ok(()),
        }
    }

    /// Creates the requested files in memory, other than those that are written during the run.
    pub fn open(&self) -> OutputFiles {
        let trace = self.trace.clone();
        let record = self.record.clone().filter(|path| !is_mcap(path));
        OutputFiles {
            trace: trace.map(|path| (path, MissionTrace::new())),
            record: record.map(|path| (path, PortRecording::of(&self.ports))),
        }
    }
}

impl OutputFiles {
    /// Records an event.
    pub fn note(&mut self, at: Time, event: &Event<'_>) {
        if let Some((_, trace)) = &mut self.trace {
            trace.note(at, event);
        }
        if let Some((_, record)) = &mut self.record {
            record.note(at, event);
        }
    }

    /// Writes the files. Returns the patterns of ports that published nothing.
    ///
    /// # Errors
    /// Fails if a file cannot be written.
    pub fn close(&self) -> Result<Vec<&str>, String> {
        if let Some((path, trace)) = &self.trace {
            std::fs::write(path, trace.text()).map_err(|error| cannot(path, error))?;
        }
        let Some((path, record)) = &self.record else {
            return Ok(Vec::new());
        };
        let file = File::create(path).map_err(|error| cannot(path, error))?;
        let written = record.write(io::BufWriter::new(file));
        written.map_err(|error| cannot(path, error))?;
        Ok(record.unmatched_patterns().collect())
    }
}

/// Returns whether a file is to be MCAP, by its name.
fn is_mcap(path: &str) -> bool {
    let suffix = Path::new(path).extension();
    suffix.is_some_and(|suffix| suffix.eq_ignore_ascii_case("mcap"))
}

fn cannot(path: &str, error: impl std::fmt::Display) -> String {
    format!("cannot write `{path}`: {error}")
}
