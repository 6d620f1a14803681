//! Files written by a run: the trace and the recording.

mod growing;

use std::path::Path;

use asmotion_component::Time;
use asmotion_recording::RecordingProfile;
use asmotion_runtime::Event;
use clap::{Args, ValueEnum};

use crate::mission::RecordingRequest;
use crate::terminal::print_warning;
use growing::{TableFile, TraceFile};

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
    trace: Option<TraceFile>,
    table: Option<TableFile>,
    /// The first error of writing, after which nothing is written.
    failure: Option<String>,
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

    /// Returns whether steps are written to a file other than MCAP.
    pub fn traces_steps(&self) -> bool {
        self.trace.is_some()
    }

    /// Opens the requested files, other than MCAP.
    ///
    /// # Errors
    /// Fails if a file cannot be written.
    pub fn open(&self) -> Result<OutputFiles, String> {
        let trace = self.trace.as_ref().map(|path| {
            let file = TraceFile::open(path);
            file.map_err(|error| cannot(path, error))
        });
        let table = self.record.as_ref().filter(|path| !is_mcap(path));
        let table = table.map(|path| {
            let file = TableFile::open(path, &self.ports);
            file.map_err(|error| cannot(path, error))
        });
        Ok(OutputFiles {
            trace: trace.transpose()?,
            table: table.transpose()?,
            failure: None,
        })
    }
}

impl OutputFiles {
    /// Returns whether there are files to write.
    pub fn is_any(&self) -> bool {
        self.trace.is_some() || self.table.is_some()
    }

    /// Records an event. If a file can no longer be written, this is reported, and the run goes on.
    pub fn note(&mut self, at: Time, event: &Event<'_>) {
        if self.failure.is_some() {
            return;
        }
        if let Some(file) = &mut self.trace {
            file.trace().note(at, event);
            let written = file.write_due();
            self.failure = written.err().map(|error| cannot(file.path(), error));
        }
        if let Some(file) = &mut self.table {
            file.recording().note(at, event);
            let failed = file.write_due().err();
            let failed = failed.map(|error| cannot(file.path(), error));
            self.failure = self.failure.take().or(failed);
        }
        if let Some(failure) = &self.failure {
            print_warning(failure);
        }
    }

    /// Completes the files. Returns the patterns of ports that published nothing.
    ///
    /// # Errors
    /// Fails if a file cannot be written.
    pub fn close(&mut self) -> Result<Vec<&str>, String> {
        if let Some(failure) = &self.failure {
            return Err(failure.clone());
        }
        if let Some(file) = &mut self.trace {
            let written = file.write();
            written.map_err(|error| cannot(file.path(), error))?;
        }
        let Some(file) = &mut self.table else {
            return Ok(Vec::new());
        };
        let written = file.finish();
        written.map_err(|error| cannot(file.path(), error))?;
        Ok(file.unmatched_patterns().collect())
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
